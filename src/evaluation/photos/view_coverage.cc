#include "lsmvs/evaluation/photos/view_coverage.h"

#include <algorithm>

namespace lsmvs {

namespace {

bool InsideImage(const View& view, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector3d x_in_cam = view.cam_from_world * x_in_world;
  return x_in_cam.z() > 0 && view.camera.Contains(view.camera.Project(x_in_cam));
}

bool Sees(const View& view, const Eigen::Vector3d& x_in_world, const MeshTracer* occluder,
          double tolerance) {
  if (!InsideImage(view, x_in_world)) return false;
  if (occluder == nullptr) return true;
  const Eigen::Vector3d center = view.CenterInWorld();
  const Eigen::Vector3d ray = x_in_world - center;
  const double length = ray.norm();
  if (length <= tolerance) return true;
  return !occluder->Occluded(center, ray / length, 0, length - tolerance);
}

double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace

std::vector<int> CountViews(const std::vector<Eigen::Vector3d>& points,
                            const std::vector<View>& views, const MeshTracer* occluder,
                            double tolerance, const RunContext& context) {
  std::vector<int> counts(points.size());
  ParallelFor(context, points.size(), 1024, [&](size_t i) {
    for (const View& view : views) counts[i] += Sees(view, points[i], occluder, tolerance);
  });
  return counts;
}

double SurfaceSamplingDistance(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<View>& views) {
  std::vector<double> distances, depths;
  for (const View& view : views) {
    depths.clear();
    for (const Eigen::Vector3d& x : points) {
      if (InsideImage(view, x)) depths.push_back(view.Depth(x));
    }
    if (!depths.empty()) distances.push_back(Median(&depths) / view.camera.fx);
  }
  return distances.empty() ? 0 : Median(&distances);
}

}  // namespace lsmvs
