#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What a cloud shows without a truth.
struct CloudFigures {
  size_t num_points = 0;  // that are finite
  // Mean number of photos that see a point, and mean of its own scores, if its file tells them.
  std::optional<double> mean_views, mean_score;
  // With views: share of their cells of kCloudCellPixels x kCloudCellPixels pixels that a point
  // lies in, mean over the views. A point counts in all views that it lies before and inside;
  // hidden points count too, since a cloud hides nothing.
  std::optional<double> coverage;
};
inline constexpr int kCloudCellPixels = 4;

// `num_views`, `scores`: per point, or empty. O(#points * #views) time.
CloudFigures MeasureCloud(const std::vector<Eigen::Vector3d>& points,
                          const std::vector<int>& num_views, const std::vector<float>& scores,
                          const std::vector<View>& views, const RunContext& context);

}  // namespace lsmvs
