#include "lsmvs/evaluation/seam_photos.h"

#include <algorithm>
#include <memory>

#include "lsmvs/image/sampling.h"

namespace lsmvs {

namespace {

// Views of a pair that are tried, those that show it largest first.
constexpr size_t kMaxTried = 4;
// What lies before a point by less than this many pixels' widths does not hide it.
constexpr double kHiddenBy_px = 3;
constexpr double kMargin_px = 2;

struct Sight {
  int view_idx;
  double size;  // pixels per world unit, in the direction in which the surface looks smallest
};

class PairInspector {
 public:
  PairInspector(const SeamPhotos& photos) : photos_(photos) {
    for (size_t v = 0; v < photos.images.num_views(); ++v) {
      cameras_.push_back(photos.images.Camera(static_cast<int>(v), 0));
    }
  }

  // The view to look at; -1: none.
  int BestView(const PointPair& pair) const {
    std::vector<Sight> sights;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const double size =
          std::min(SizeOf(v, pair.a, pair.normal_a), SizeOf(v, pair.b, pair.normal_b));
      if (size > 0) sights.push_back({static_cast<int>(v), size});
    }
    std::stable_sort(sights.begin(), sights.end(),
                     [](const Sight& a, const Sight& b) { return a.size > b.size; });
    sights.resize(std::min(sights.size(), kMaxTried));
    for (const Sight& sight : sights) {
      const auto v = static_cast<size_t>(sight.view_idx);
      if (IsOpen(v, pair.a) && IsOpen(v, pair.b)) return sight.view_idx;
    }
    return -1;
  }

 private:
  const View& ViewOf(size_t v) const { return photos_.scene.views[v]; }

  // 0 where the view does not show the point.
  double SizeOf(size_t v, const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
    if (!ViewOf(v).has_photo) return 0;
    const Eigen::Vector3d in_cam = ViewOf(v).cam_from_world * x;
    if (!(in_cam.z() > 0)) return 0;
    const Eigen::Vector2d x_px = cameras_[v].Project(in_cam);
    const Eigen::Vector2d last(cameras_[v].width - kMargin_px, cameras_[v].height - kMargin_px);
    if (x_px.minCoeff() < kMargin_px || (x_px - last).maxCoeff() > 0) return 0;
    const Eigen::Vector3d sight = ViewOf(v).CenterInWorld() - x;
    const double cosine = normal.dot(sight) / (normal.norm() * sight.norm());
    return cosine > 0 ? cameras_[v].MeanFocalLength() * cosine / in_cam.z() : 0;
  }

  bool IsOpen(size_t v, const Eigen::Vector3d& x) const {
    const double end = 1 - kHiddenBy_px / cameras_[v].MeanFocalLength();
    const Eigen::Vector3d center = ViewOf(v).CenterInWorld();
    return !photos_.tracer.Occluded(center, x - center, 0, end);
  }

  const SeamPhotos& photos_;
  std::vector<PinholeCamera> cameras_;
};

}  // namespace

std::vector<std::optional<float>> MeasurePhotoSteps(const std::vector<PointPair>& pairs,
                                                    const SeamPhotos& photos,
                                                    const RunContext& context) {
  const PairInspector inspector(photos);
  std::vector<int> view_of(pairs.size());
  ParallelFor(context, pairs.size(), 256,
              [&](size_t i) { view_of[i] = inspector.BestView(pairs[i]); });
  std::vector<std::vector<size_t>> pairs_of(photos.images.num_views());
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (view_of[i] >= 0) pairs_of[static_cast<size_t>(view_of[i])].push_back(i);
  }
  std::vector<std::optional<float>> steps(pairs.size());
  for (size_t v = 0; v < pairs_of.size(); ++v) {
    context.ThrowIfCancelled();
    if (pairs_of[v].empty()) continue;
    const PinholeCamera camera = photos.images.Camera(static_cast<int>(v), 0);
    const std::shared_ptr<const ColorImage> photo = photos.images.Colors(static_cast<int>(v), 0);
    const auto color = [&](const Eigen::Vector3d& x) {
      const Eigen::Vector2d x_px = camera.Project(photos.scene.views[v].cam_from_world * x);
      return SampleColors(*photo, x_px.x(), x_px.y());
    };
    for (const size_t i : pairs_of[v]) {
      steps[i] = (color(pairs[i].a) - color(pairs[i].b)).cwiseAbs().mean();
    }
  }
  return steps;
}

}  // namespace lsmvs
