#include "lsmvs/evaluation/atlas_figures.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/mesh/texture_charts.h"

namespace lsmvs {

namespace {

constexpr float kSeamTexels = 1, kInnerBegin = 7, kInnerEnd = 9;
constexpr float kSampleTexels = 4;

// One side of a seam sample: what its page shows there.
struct Side {
  int face, chart;
  Eigen::Vector2f x_px, inward;  // on the seam; unit length
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  bool is_inside = false;  // whether the texel next to the seam is the chart's own
  float inner_step = -1;   // below 0: the chart is too narrow there
};

// Calls visit(column, row) for the texels whose centres lie in a triangle.
template <class Visit>
void ForTexelsInside(const std::array<Eigen::Vector2f, 3>& t, int width, int height,
                     const Visit& visit) {
  const Eigen::Vector2f low = t[0].cwiseMin(t[1]).cwiseMin(t[2]),
                        high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  const int left = std::max(0, static_cast<int>(std::ceil(low.x() - 0.5f))),
            right = std::min(width - 1, static_cast<int>(std::floor(high.x() - 0.5f))),
            top = std::max(0, static_cast<int>(std::ceil(low.y() - 0.5f))),
            bottom = std::min(height - 1, static_cast<int>(std::floor(high.y() - 0.5f)));
  const auto cross = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  for (int row = top; row <= bottom; ++row) {
    for (int column = left; column <= right; ++column) {
      const Eigen::Vector2f x(static_cast<float>(column) + 0.5f, static_cast<float>(row) + 0.5f);
      const float a = cross(t[1] - t[0], x - t[0]), b = cross(t[2] - t[1], x - t[1]),
                  c = cross(t[0] - t[2], x - t[2]);
      if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0)) visit(column, row);
    }
  }
}

class AtlasMeter {
 public:
  AtlasMeter(const TexturePages& pages, const SeamPhotos* photos, const RunContext& context)
      : pages_(pages),
        textured_(pages.textured()),
        photos_(photos),
        context_(context),
        charts_(FindTextureCharts(textured_)) {}

  AtlasFigures Measure() {
    FindSeams();
    double num_covered = 0;
    for (size_t p = 0; p < textured_.pages.size(); ++p) num_covered += MeasurePage(p);
    figures_.num_pages = textured_.pages.size();
    figures_.num_charts = charts_.num_charts;
    figures_.utilisation = figures_.num_texels > 0 ? num_covered / figures_.num_texels : 0;
    CompareSides();
    return figures_;
  }

 private:
  // Texture coordinates of a face in pixels of its page's file.
  std::array<Eigen::Vector2f, 3> FilePixels(size_t face, const ColorImage& page) const {
    return {pages_.FilePixel(face, {0, 0}, page), pages_.FilePixel(face, {1, 0}, page),
            pages_.FilePixel(face, {0, 1}, page)};
  }

  void FindSeams() {
    const std::vector<HalfEdge> sides =
        SortedHalfEdges(textured_.mesh.faces, textured_.mesh.vertices.size());
    ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
      if (end - begin != 2) return;
      if (ContinueInTexture(textured_, begin[0].face, begin[1].face, begin->low, begin->high)) {
        return;
      }
      AddSamples(begin[0].face, begin[1].face, begin->low, begin->high);
    });
  }

  // Texture coordinates of two corners and the third.
  std::array<Eigen::Vector2f, 3> Corners(int face, int low, int high) const {
    const Eigen::Vector3i& f = textured_.mesh.faces[face];
    std::array<Eigen::Vector2f, 3> corners;
    for (int c = 0; c < 3; ++c) {
      corners[f[c] == low    ? 0
              : f[c] == high ? 1
                             : 2] =
          textured_.texcoords[static_cast<size_t>(face)][static_cast<size_t>(c)];
    }
    return corners;
  }

  void AddSamples(int face_a, int face_b, int low, int high) {
    const auto a = Corners(face_a, low, high), b = Corners(face_b, low, high);
    const int count = std::max(1, static_cast<int>((a[1] - a[0]).norm() / kSampleTexels));
    for (int i = 0; i < count; ++i) {
      const float s = (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
      AddSide(face_a, a, s);
      AddSide(face_b, b, s);
    }
  }

  void AddSide(int face, const std::array<Eigen::Vector2f, 3>& corners, float s) {
    const Eigen::Vector2f edge = corners[1] - corners[0];
    Eigen::Vector2f inward(-edge.y(), edge.x());
    if (inward.dot(corners[2] - corners[0]) < 0) inward = -inward;
    const float length = inward.norm();
    sides_.push_back(
        {face, charts_.chart_of_face[static_cast<size_t>(face)], corners[0] + s * edge,
         length > 0 ? Eigen::Vector2f(inward / length) : Eigen::Vector2f(Eigen::Vector2f::Zero())});
  }

  // Returns the number of covered texels.
  double MeasurePage(size_t p) {
    const std::shared_ptr<const ColorImage> page = pages_.Page(p);
    figures_.num_texels += static_cast<double>(page->size());
    Raster<int32_t> chart_at(page->width, page->height, -1);
    for (size_t f = 0; f < textured_.mesh.faces.size(); ++f) {
      if (textured_.page_idx[f] != p) continue;
      ForTexelsInside(FilePixels(f, *page), page->width, page->height,
                      [&](int x, int y) { chart_at(x, y) = charts_.chart_of_face[f]; });
    }
    const Eigen::Vector2f stretch(
        static_cast<float>(page->width) / static_cast<float>(textured_.page_width),
        static_cast<float>(page->height) / static_cast<float>(textured_.page_height));
    for (Side& side : sides_) {
      if (textured_.page_idx[static_cast<size_t>(side.face)] != p) continue;
      LookAtSide(*page, chart_at, side.x_px.cwiseProduct(stretch), &side);
    }
    return static_cast<double>(std::count_if(chart_at.pixels.begin(), chart_at.pixels.end(),
                                             [](int c) { return c >= 0; }));
  }

  static void LookAtSide(const ColorImage& page, const Raster<int32_t>& chart_at,
                         const Eigen::Vector2f& x_px, Side* side) {
    const auto at = [&](float distance) -> Eigen::Vector2f {
      return x_px + distance * side->inward;
    };
    side->color = SampleColor(page, at(kSeamTexels));
    for (float d = kSeamTexels; d <= kInnerEnd + 1; d += 1) {
      const Eigen::Vector2i texel = at(d).cast<int>();
      if (!chart_at.Inside(texel.x(), texel.y()) || chart_at(texel.x(), texel.y()) != side->chart) {
        return;
      }
      side->is_inside = true;
    }
    side->inner_step =
        (SampleColor(page, at(kInnerBegin)) - SampleColor(page, at(kInnerEnd))).cwiseAbs().mean();
  }

  // Samples of which at least one side tells what the texture does by itself.
  std::vector<size_t> FirstSidesOfSamples() const {
    std::vector<size_t> samples;
    for (size_t i = 0; i + 1 < sides_.size(); i += 2) {
      const Side &a = sides_[i], &b = sides_[i + 1];
      if (!a.is_inside || !b.is_inside) continue;
      if (a.inner_step >= 0 || b.inner_step >= 0) samples.push_back(i);
    }
    return samples;
  }

  // The point of the surface that the texel next to the seam shows, on the plane of the face.
  Eigen::Vector3d PointBeside(const Side& side) const {
    const auto& t = textured_.texcoords[static_cast<size_t>(side.face)];
    Eigen::Matrix2f edges;
    edges << t[1] - t[0], t[2] - t[0];
    const Eigen::Vector2f x = side.x_px + kSeamTexels * side.inward - t[0];
    Eigen::Vector2f weights = Eigen::Vector2f::Constant(1.0f / 3);
    if (edges.determinant() != 0) weights = edges.inverse() * x;
    const Eigen::Vector3i& f = textured_.mesh.faces[side.face];
    const auto& v = textured_.mesh.vertices;
    return v[f[0]] + static_cast<double>(weights[0]) * (v[f[1]] - v[f[0]]) +
           static_cast<double>(weights[1]) * (v[f[2]] - v[f[0]]);
  }

  // Of each sample; all without photos count as seen.
  std::vector<std::optional<float>> PhotoSteps(const std::vector<size_t>& samples) const {
    if (photos_ == nullptr) return std::vector<std::optional<float>>(samples.size(), 0.0f);
    std::vector<PointPair> pairs;
    for (const size_t i : samples) {
      const Side &a = sides_[i], &b = sides_[i + 1];
      pairs.push_back({PointBeside(a), PointBeside(b),
                       FaceNormalTimesTwiceArea(textured_.mesh, static_cast<size_t>(a.face)),
                       FaceNormalTimesTwiceArea(textured_.mesh, static_cast<size_t>(b.face))});
    }
    return MeasurePhotoSteps(pairs, *photos_, context_);
  }

  void CompareSides() {
    const std::vector<size_t> samples = FirstSidesOfSamples();
    const std::vector<std::optional<float>> photo_steps = PhotoSteps(samples);
    double seam = 0, inner = 0, photo = 0;
    for (size_t s = 0; s < samples.size(); ++s) {
      if (!photo_steps[s]) continue;
      const Side &a = sides_[samples[s]], &b = sides_[samples[s] + 1];
      const int num_inner = (a.inner_step >= 0) + (b.inner_step >= 0);
      seam += (a.color - b.color).cwiseAbs().mean();
      inner += (std::max(0.0f, a.inner_step) + std::max(0.0f, b.inner_step)) /
               static_cast<float>(num_inner);
      photo += *photo_steps[s];
      ++figures_.num_seam_samples;
    }
    if (figures_.num_seam_samples == 0) return;
    const auto n = static_cast<double>(figures_.num_seam_samples);
    figures_.seam_step = seam / n;
    figures_.inner_step = inner / n;
    figures_.seam_ratio = inner > 0 ? seam / inner : 0;
    figures_.photo_step = photo / n;
    figures_.photo_ratio = photo > 0 ? seam / photo : 0;
  }

  const TexturePages& pages_;
  const TexturedMesh& textured_;
  const SeamPhotos* photos_;
  const RunContext& context_;
  const TextureCharts charts_;
  std::vector<Side> sides_;  // two after each other are the sides of one sample
  AtlasFigures figures_;
};

}  // namespace

AtlasFigures MeasureAtlas(const TexturePages& pages, const SeamPhotos* photos,
                          const RunContext& context) {
  return AtlasMeter(pages, photos, context).Measure();
}

}  // namespace lsmvs
