#include "lsmvs/evaluation/cloud_figures.h"

#include <algorithm>
#include <numeric>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

template <class T>
std::optional<double> Mean(const std::vector<T>& values) {
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double CoveredShare(const std::vector<Eigen::Vector3d>& points, const View& view) {
  const auto cells = [](int pixels) { return (pixels + kCloudCellPixels - 1) / kCloudCellPixels; };
  const int columns = cells(view.camera.width), rows = cells(view.camera.height);
  std::vector<char> covered(static_cast<size_t>(columns) * static_cast<size_t>(rows), 0);
  for (const Eigen::Vector3d& x : points) {
    const Eigen::Vector3d x_in_cam = view.cam_from_world * x;
    if (!(x_in_cam.z() > 0)) continue;
    const Eigen::Vector2d x_px = view.camera.Project(x_in_cam);
    if (!view.camera.Contains(x_px)) continue;
    const int column = static_cast<int>(x_px.x()) / kCloudCellPixels;
    const int row = static_cast<int>(x_px.y()) / kCloudCellPixels;
    covered[static_cast<size_t>(row) * static_cast<size_t>(columns) + static_cast<size_t>(column)] =
        1;
  }
  return static_cast<double>(std::count(covered.begin(), covered.end(), 1)) /
         static_cast<double>(covered.size());
}

}  // namespace

CloudFigures MeasureCloud(const std::vector<Eigen::Vector3d>& points,
                          const std::vector<int>& num_views, const std::vector<float>& scores,
                          const std::vector<View>& views, const RunContext& context) {
  LSMVS_CHECK(num_views.empty() || num_views.size() == points.size());
  LSMVS_CHECK(scores.empty() || scores.size() == points.size());
  CloudFigures figures;
  figures.num_points = static_cast<size_t>(std::count_if(
      points.begin(), points.end(), [](const Eigen::Vector3d& x) { return x.allFinite(); }));
  figures.mean_views = Mean(num_views);
  figures.mean_score = Mean(scores);
  std::vector<double> shares(views.size());
  ParallelFor(context, views.size(), 1,
              [&](size_t v) { shares[v] = CoveredShare(points, views[v]); });
  figures.coverage = Mean(shares);
  return figures;
}

}  // namespace lsmvs
