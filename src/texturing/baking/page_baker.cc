#include "lsmvs/texturing/baking/page_baker.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <tuple>

#include "lsmvs/image/hole_filling.h"
#include "lsmvs/image/largest_image.h"
#include "lsmvs/image/sampling.h"
#include "lsmvs/image/triangle_spans.h"

namespace lsmvs {

namespace {

constexpr uint8_t kNothing = 0, kAround = 1, kInFace = 2;
constexpr int kRingsAround = 2;

// A face that is drawn into a chart with one photo.
struct Draw {
  int32_t view_idx;  // -1: fill colours
  uint32_t chart, face;
  uint8_t coverage;  // kInFace, or kAround for faces of other charts
};

// What a photo adds at the corners of a face.
struct CornerWeights {
  Eigen::Vector3d weight = Eigen::Vector3d::Ones();  // of the photo
  Eigen::Vector3d before = Eigen::Vector3d::Zero();  // of what is drawn before
  Eigen::Matrix3d offset = Eigen::Matrix3d::Zero();  // columns: corners

  // Part of the photo in the mix with what is drawn before.
  double Part(const Eigen::Vector3d& barycentric) const {
    const double own = std::max(0.0, weight.dot(barycentric));
    const double sum = own + std::max(0.0, before.dot(barycentric));
    return sum > 0 ? own / sum : 0;
  }
};

class PageBaker {
 public:
  PageBaker(const Scene& scene, const ImageStore& images, const LabelEnergy& energy,
            const SurfaceAppearance& appearance, const Charts& charts, int page_idx, int page_side,
            const RunContext& context)
      : scene_(scene),
        images_(images),
        energy_(energy),
        appearance_(appearance),
        charts_(charts),
        page_idx_(page_idx),
        context_(context) {
    page_.colors = ColorImage(page_side, page_side, Color::Zero());
    page_.coverage = Raster<uint8_t>(page_side, page_side, kNothing);
  }

  BakedPage Run() {
    std::vector<Draw> draws = CollectDraws();
    const std::vector<Draw> fades = CollectFades(draws);
    DrawAll(std::move(draws), false);
    DrawAll(fades, true);
    FillHoles(page_.coverage, &page_.colors);
    return std::move(page_);
  }

 private:
  std::vector<Draw> CollectDraws() const {
    std::vector<Draw> draws;
    for (uint32_t c = 0; c < charts_.charts.size(); ++c) {
      const Chart& chart = charts_.charts[c];
      if (chart.page_idx != page_idx_) continue;
      for (const uint32_t f : charts_.FacesOf(chart)) {
        if (IsGuest(chart, f)) continue;  // shows what is there
        draws.push_back({appearance_.views[f], c, f, kInFace});
      }
      AddFacesAround(c, &draws);
    }
    return draws;
  }

  int NumViews() const { return static_cast<int>(scene_.views.size()); }
  bool IsGuest(const Chart& chart, uint32_t face) const {
    return chart.label < NumViews() && appearance_.views[face] != chart.label;
  }

  // Faces of other charts within two rings that the chart's photo shows.
  void AddFacesAround(uint32_t c, std::vector<Draw>* draws) const {
    const Chart& chart = charts_.charts[c];
    const auto inside = charts_.FacesOf(chart);
    if (chart.label >= NumViews()) return;
    std::vector<uint32_t> ring(inside.begin(), inside.end()), around;
    for (int r = 0; r < kRingsAround; ++r) {
      std::vector<uint32_t> next;
      for (const uint32_t f : ring) {
        for (const int32_t neighbor : energy_.neighbors()[f]) {
          if (neighbor < 0) continue;
          const auto g = static_cast<uint32_t>(neighbor);
          if (std::binary_search(inside.begin(), inside.end(), g)) continue;
          if (appearance_.views[g] >= 0 && energy_.candidates().Find(g, chart.label) != nullptr) {
            next.push_back(g);
          }
        }
      }
      std::sort(next.begin(), next.end());
      next.erase(std::unique(next.begin(), next.end()), next.end());
      around.insert(around.end(), next.begin(), next.end());
      ring.swap(next);
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    for (const uint32_t g : around) draws->push_back({appearance_.views[g], c, g, kAround});
  }

  // The same faces with the photos that are mixed in.
  std::vector<Draw> CollectFades(const std::vector<Draw>& draws) const {
    std::vector<Draw> fades;
    std::vector<int32_t> views;
    for (const Draw& draw : draws) {
      if (draw.view_idx < 0) continue;
      views.clear();
      for (const int v : energy_.mesh().faces[draw.face]) {
        for (const PhotoShare& share : appearance_.fades.Of(static_cast<size_t>(v))) {
          if (share.view_idx != draw.view_idx) views.push_back(share.view_idx);
        }
      }
      std::sort(views.begin(), views.end());
      views.erase(std::unique(views.begin(), views.end()), views.end());
      for (const int32_t view : views) {
        fades.push_back({view, draw.chart, draw.face, draw.coverage});
      }
    }
    return fades;
  }

  // Photo after photo; charts in parallel, since no two touch the same texel.
  void DrawAll(std::vector<Draw> draws, bool are_fades) {
    const auto key = [&](const Draw& draw) {
      return std::make_tuple(draw.view_idx, LevelOf(draw), draw.chart);
    };
    std::stable_sort(draws.begin(), draws.end(),
                     [&](const Draw& a, const Draw& b) { return key(a) < key(b); });
    for (size_t begin = 0; begin < draws.size();) {
      size_t end = begin;
      const auto same = [&](const Draw& draw) {
        return draw.view_idx == draws[begin].view_idx && LevelOf(draw) == LevelOf(draws[begin]);
      };
      while (end < draws.size() && same(draws[end])) ++end;
      DrawPhoto({draws.data() + begin, end - begin}, are_fades);
      begin = end;
    }
  }

  int LevelOf(const Draw& draw) const {
    return draw.view_idx < 0 ? 0 : charts_.charts[draw.chart].photo_level;
  }

  void DrawPhoto(std::span<const Draw> draws, bool are_fades) {
    const int view_idx = draws.front().view_idx, level = LevelOf(draws.front());
    std::shared_ptr<const ColorImage> photo;
    if (view_idx >= 0) photo = images_.Colors(view_idx, level);
    TrimToViewsHeld(images_);
    std::vector<size_t> begins;  // of the charts
    for (size_t i = 0; i < draws.size(); ++i) {
      if (i == 0 || draws[i].chart != draws[i - 1].chart) begins.push_back(i);
    }
    begins.push_back(draws.size());
    ParallelFor(context_, begins.size() - 1, 1, [&](size_t b) {
      for (size_t i = begins[b]; i < begins[b + 1]; ++i) {
        if (view_idx < 0) {
          DrawFill(draws[i]);
        } else {
          DrawFace(draws[i], *photo, images_.Camera(view_idx, level), are_fades);
        }
      }
    });
  }

  // Calls visit(texel on the page, barycentric coordinates) for the texels of the face that the
  // draw may touch.
  template <class Visit>
  void ForTexels(const Draw& draw, const Visit& visit) {
    const Chart& chart = charts_.charts[draw.chart];
    const Eigen::Vector3i& face = energy_.mesh().faces[draw.face];
    std::array<Eigen::Vector2d, 3> corners;
    for (int k = 0; k < 3; ++k) {
      corners[static_cast<size_t>(k)] =
          chart.map(energy_.mesh().vertices[face[k]]) - chart.origin.cast<double>();
    }
    Eigen::Matrix2d edges;
    edges << corners[1] - corners[0], corners[2] - corners[0];
    if (edges.determinant() == 0) return;
    const Eigen::Matrix2d inverse = edges.inverse();
    ForTriangleSpans(corners, chart.size.x(), chart.size.y(), [&](int row, int begin, int end) {
      for (int column = begin; column < end; ++column) {
        const size_t texel =
            page_.colors.Index(chart.position.x() + column, chart.position.y() + row);
        if (page_.coverage.pixels[texel] > draw.coverage) continue;
        const Eigen::Vector2d b = inverse * (Eigen::Vector2d(column + 0.5, row + 0.5) - corners[0]);
        visit(texel, Eigen::Vector3d(1 - b.x() - b.y(), b.x(), b.y()));
      }
    });
  }

  void DrawFill(const Draw& draw) {
    const Eigen::Vector3i& face = energy_.mesh().faces[draw.face];
    Eigen::Matrix3f colors;
    for (int k = 0; k < 3; ++k) {
      colors.col(k) = appearance_.fill_colors[static_cast<size_t>(face[k])];
    }
    ForTexels(draw, [&](size_t texel, const Eigen::Vector3d& b) {
      page_.colors.pixels[texel] = RoundColor(colors * b.cast<float>());
      page_.coverage.pixels[texel] = draw.coverage;
    });
  }

  void DrawFace(const Draw& draw, const ColorImage& photo, const PinholeCamera& camera,
                bool is_fade) {
    const Rigid3& cam_from_world = scene_.views[static_cast<size_t>(draw.view_idx)].cam_from_world;
    const Eigen::Vector3i& face = energy_.mesh().faces[draw.face];
    Eigen::Matrix3d corners_in_cam;
    for (int k = 0; k < 3; ++k) {
      corners_in_cam.col(k) = cam_from_world * energy_.mesh().vertices[face[k]];
    }
    const CornerWeights at_corners =
        is_fade ? FadeWeights(draw.face, draw.view_idx) : OwnWeights(draw.face);
    const Eigen::Vector3f& gain = appearance_.gains[static_cast<size_t>(draw.view_idx)];
    ForTexels(draw, [&](size_t texel, const Eigen::Vector3d& b) {
      const Eigen::Vector2d x_px = camera.Project(corners_in_cam * b);
      Eigen::Vector3f color = SampleColors(photo, x_px.x(), x_px.y()).cwiseProduct(gain) +
                              (at_corners.offset * b).cast<float>();
      if (is_fade) {
        const Eigen::Vector3f base = page_.colors.pixels[texel].cast<float>();
        color = base + static_cast<float>(at_corners.Part(b)) * (color - base);
      }
      page_.colors.pixels[texel] = RoundColor(color);
      page_.coverage.pixels[texel] = draw.coverage;
    });
  }

  CornerWeights OwnWeights(size_t face) const {
    CornerWeights result;
    for (size_t k = 0; k < 3; ++k) {
      const int32_t node = appearance_.nodes.of_face[face][k];
      result.offset.col(static_cast<Eigen::Index>(k)) =
          appearance_.offsets[static_cast<size_t>(node)].cast<double>();
    }
    return result;
  }

  // Photos are drawn in the order of the views, after the face's own. Corners where the photo has
  // no share have the mean offset of those where it has.
  CornerWeights FadeWeights(size_t face, int32_t view_idx) const {
    CornerWeights result;
    result.weight.setZero();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    int count = 0;
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<size_t>(energy_.mesh().faces[face][k]);
      const auto shares = appearance_.fades.Of(v);
      if (shares.empty()) result.before[k] = 1;
      for (const PhotoShare& share : shares) {
        if (share.view_idx == view_idx) {
          result.weight[k] = share.weight;
          result.offset.col(k) = share.offset.cast<double>();
          mean += result.offset.col(k);
          ++count;
        } else if (share.view_idx < view_idx || share.view_idx == appearance_.views[face]) {
          result.before[k] += share.weight;
        }
      }
    }
    for (int k = 0; k < 3; ++k) {
      if (result.weight[k] == 0) result.offset.col(k) = mean / count;
    }
    return result;
  }

  const Scene& scene_;
  const ImageStore& images_;
  const LabelEnergy& energy_;
  const SurfaceAppearance& appearance_;
  const Charts& charts_;
  int page_idx_;
  const RunContext& context_;
  BakedPage page_;
};

}  // namespace

BakedPage BakePage(const Scene& scene, const ImageStore& images, const LabelEnergy& energy,
                   const SurfaceAppearance& appearance, const Charts& charts, int page_idx,
                   int page_side, const RunContext& context) {
  return PageBaker(scene, images, energy, appearance, charts, page_idx, page_side, context).Run();
}

}  // namespace lsmvs
