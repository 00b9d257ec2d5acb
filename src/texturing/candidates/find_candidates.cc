#include "lsmvs/texturing/candidates/find_candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>

#include "lsmvs/image/largest_image.h"
#include "lsmvs/image/rasterizer.h"
#include "lsmvs/image/sampling.h"
#include "lsmvs/texturing/candidates/photo_validity.h"
#include "lsmvs/texturing/candidates/sharpness_map.h"
#include "lsmvs/util/ordered_merge.h"

namespace lsmvs {

namespace {

constexpr double kMinCosine = 0.05;  // 3 degrees from edge-on
// What is nearer by this many pixels' widths on the surface hides a face; less is the roughness of
// the mesh, and makes the photo doubtful.
constexpr double kHiddenBy_px = 12, kDoubtfulBy_px = 2;
constexpr double kLargeFace_px = 8, kLatticeStep_px = 4;
constexpr float kDoubtfulFactor = 0.1f;
// A photo whose sharpness is at least this part of the sharpest one's is as good.
constexpr float kSharpEnough = 0.75f, kLeastSharpFactor = 0.2f;
constexpr size_t kFacesPerBlock = 16384;

struct SeenFace {
  int32_t face;
  float density;
  Candidate candidate;
};

// What a view shows of single faces.
class PhotoInspector {
 public:
  PhotoInspector(const View& view, const ImageStore& images, int view_idx, const TriangleMesh& mesh)
      : view_idx_(view_idx),
        cam_from_world_(view.cam_from_world),
        center_(view.CenterInWorld()),
        camera_(images.Camera(view_idx, 0)),
        mesh_(mesh),
        colors_(images.Colors(view_idx, 0)),
        sharpness_(*colors_),
        pixel_width_(1 / camera_.MeanFocalLength()) {
    SurfaceMaps maps;
    RasterizeMesh(camera_, cam_from_world_, mesh.vertices, mesh.faces, {}, &maps);
    depth_ = std::move(maps.depth);
    const auto mask = images.Mask(view_idx, 0);
    validity_ = FindValidPixels(camera_, depth_, *colors_, mask.get());
  }

  std::vector<SeenFace> Run() const {
    std::vector<SeenFace> seen;
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (!FacesCamera(f)) continue;
      if (const auto face = Inspect(f)) seen.push_back(*face);
    }
    return seen;
  }

 private:
  struct Corners {
    std::array<Eigen::Vector3d, 3> x_in_cam;
    std::array<Eigen::Vector2d, 3> x_px;
  };

  // Sums over the sample points of a face.
  struct Samples {
    Eigen::Vector3f color_sum = Eigen::Vector3f::Zero();
    int count = 0;
    bool doubtful = false;
  };

  bool FacesCamera(size_t f) const {
    const Eigen::Vector3i& face = mesh_.faces[f];
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh_, f);
    const Eigen::Vector3d middle =
        (mesh_.vertices[face[0]] + mesh_.vertices[face[1]] + mesh_.vertices[face[2]]) / 3.0;
    const Eigen::Vector3d sight = center_ - middle;
    const double dot = normal.dot(sight);
    return dot > 0 &&
           dot * dot > kMinCosine * kMinCosine * normal.squaredNorm() * sight.squaredNorm();
  }

  std::optional<Corners> Project(size_t f) const {
    Corners corners;
    for (size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d x = cam_from_world_ * mesh_.vertices[mesh_.faces[f][k]];
      if (!(x.z() > 0)) return std::nullopt;
      corners.x_in_cam[k] = x;
      corners.x_px[k] = camera_.Project(x);
      if (!camera_.Contains(corners.x_px[k])) return std::nullopt;
    }
    return corners;
  }

  std::optional<SeenFace> Inspect(size_t f) const {
    const std::optional<Corners> corners = Project(f);
    if (!corners) return std::nullopt;
    Samples samples;
    if (!SampleFace(*corners, &samples)) return std::nullopt;
    SeenFace seen;
    seen.face = static_cast<int32_t>(f);
    seen.density = static_cast<float>(Density(*corners));
    if (!(seen.density > 0)) return std::nullopt;
    seen.candidate.view_idx = view_idx_;
    seen.candidate.quality = seen.density * (samples.doubtful ? kDoubtfulFactor : 1.0f);
    seen.candidate.color = RoundColor(samples.color_sum / static_cast<float>(samples.count));
    seen.candidate.sharpness = sharpness_.At(static_cast<int>(corners->x_px[0].x()),
                                             static_cast<int>(corners->x_px[0].y()));
    return seen;
  }

  // False if a sample point cannot be used.
  bool SampleFace(const Corners& corners, Samples* samples) const {
    const auto& p = corners.x_px;
    const double longest =
        std::max({(p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm()});
    if (longest > kLargeFace_px) {
      return SampleLattice(corners, static_cast<int>(std::ceil(longest / kLatticeStep_px)),
                           samples);
    }
    static const std::array<Eigen::Vector3d, 7> kPoints = {Eigen::Vector3d(0.8, 0.1, 0.1),
                                                           {0.1, 0.8, 0.1},
                                                           {0.1, 0.1, 0.8},
                                                           {0.475, 0.475, 0.05},
                                                           {0.05, 0.475, 0.475},
                                                           {0.475, 0.05, 0.475},
                                                           Eigen::Vector3d::Constant(1.0 / 3)};
    return std::all_of(kPoints.begin(), kPoints.end(), [&](const Eigen::Vector3d& weights) {
      return SamplePoint(corners, weights, samples);
    });
  }

  // Middles of the upright ones of the n^2 parts.
  bool SampleLattice(const Corners& corners, int n, Samples* samples) const {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        const double a = (i + 1.0 / 3) / n, b = (j + 1.0 / 3) / n;
        if (!SamplePoint(corners, {a, b, 1 - a - b}, samples)) return false;
      }
    }
    return true;
  }

  bool SamplePoint(const Corners& corners, const Eigen::Vector3d& weights, Samples* samples) const {
    const Eigen::Vector3d x = weights[0] * corners.x_in_cam[0] + weights[1] * corners.x_in_cam[1] +
                              weights[2] * corners.x_in_cam[2];
    const Eigen::Vector2d x_px = camera_.Project(x);
    const int column = std::min(camera_.width - 1, static_cast<int>(x_px.x()));
    const int row = std::min(camera_.height - 1, static_cast<int>(x_px.y()));
    const uint8_t validity = validity_(column, row);
    const double nearer_px = (1 - Visible(x_px) / x.z()) / pixel_width_;
    if (validity == kInvalidPixel || nearer_px > kHiddenBy_px) return false;
    samples->doubtful |= validity == kDoubtfulPixel || nearer_px > kDoubtfulBy_px;
    samples->color_sum += SampleColors(*colors_, x_px.x(), x_px.y());
    ++samples->count;
    return true;
  }

  // Farthest depth that the camera sees in the four pixels around.
  double Visible(const Eigen::Vector2d& x_px) const {
    const int column = std::clamp(static_cast<int>(x_px.x() - 0.5), 0, camera_.width - 2);
    const int row = std::clamp(static_cast<int>(x_px.y() - 0.5), 0, camera_.height - 2);
    const float* upper = depth_.Row(row) + column;
    const float* lower = upper + depth_.width;
    return std::max({upper[0], upper[1], lower[0], lower[1]});
  }

  // Smaller singular value of the map from the face's plane to the photo.
  static double Density(const Corners& corners) {
    const Eigen::Vector3d u = corners.x_in_cam[1] - corners.x_in_cam[0];
    const Eigen::Vector3d v = corners.x_in_cam[2] - corners.x_in_cam[0];
    const double length = u.norm();
    Eigen::Matrix2d on_face, in_photo;
    on_face << length, u.dot(v) / length, 0, u.cross(v).norm() / length;
    in_photo << corners.x_px[1] - corners.x_px[0], corners.x_px[2] - corners.x_px[0];
    if (!(on_face.determinant() > 0)) return 0;
    const Eigen::Matrix2d jacobian = in_photo * on_face.inverse();
    const double trace = jacobian.squaredNorm(), determinant = std::abs(jacobian.determinant());
    const double root = std::sqrt(std::max(0.0, trace * trace - 4 * determinant * determinant));
    return determinant / std::sqrt(0.5 * (trace + root));
  }

  int view_idx_;
  const Rigid3& cam_from_world_;
  Eigen::Vector3d center_;
  PinholeCamera camera_;
  const TriangleMesh& mesh_;
  std::shared_ptr<const ColorImage> colors_;
  SharpnessMap sharpness_;
  double pixel_width_;  // on a surface that faces the camera, part of the depth
  Raster<float> depth_;
  Raster<uint8_t> validity_;
};

// Lowers the quality of photos that are blurred where others are not.
void CountSharpness(FaceCandidates* candidates, const RunContext& context) {
  ParallelFor(context, candidates->num_faces(), kFacesPerBlock, [&](size_t f) {
    float sharpest = 0;
    for (const Candidate& c : candidates->Of(f)) {
      sharpest = std::max(sharpest, static_cast<float>(c.sharpness));
    }
    for (Candidate& c : candidates->Of(f)) {
      const float ratio = static_cast<float>(c.sharpness) / (kSharpEnough * sharpest);
      c.quality *= std::clamp(ratio, kLeastSharpFactor, 1.0f);
    }
    candidates->Sort(f);
  });
}

}  // namespace

FaceCandidates FindCandidates(const Scene& scene, const ImageStore& images,
                              const TriangleMesh& mesh, int max_per_face,
                              const RunContext& context) {
  FaceCandidates candidates(mesh.faces.size(), max_per_face);
  OrderedMerge<std::vector<SeenFace>> merge([&](size_t view, std::vector<SeenFace>&& seen) {
    for (const SeenFace& s : seen) {
      candidates.Add(static_cast<size_t>(s.face), s.candidate, s.density);
    }
    context.Report(static_cast<double>(view + 1) / static_cast<double>(scene.views.size()));
  });
  // Handed out in order, whatever block a thread takes: no result waits long for those before it.
  std::atomic<size_t> next = 0;
  ParallelFor(context, scene.views.size(), 1, [&](size_t) {
    const size_t v = next++;
    const View& view = scene.views[v];
    std::vector<SeenFace> seen;
    if (view.has_photo) seen = PhotoInspector(view, images, static_cast<int>(v), mesh).Run();
    merge.Add(v, std::move(seen));
    TrimToViewsHeld(images);
  });
  CountSharpness(&candidates, context);
  candidates.Compact();
  return candidates;
}

}  // namespace lsmvs
