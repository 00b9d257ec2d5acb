#include "lsmvs/scene/cloud_overlap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>

namespace lsmvs {

namespace {

constexpr size_t kSamplePoints = 30000;
constexpr double kCellsPerCloud = 32;
// Below this share, points of two clouds meet by outliers only.
constexpr double kLeastShare = 0.005;

using Positions = std::vector<Eigen::Vector3f>;
using GridCell = std::array<int64_t, 3>;

// Of the middle 80 % of the points along each axis.
struct Extent {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), size = Eigen::Vector3d::Zero();
};

Extent MeasureExtent(const Positions& points) {
  constexpr double kLow = 0.1, kMiddle = 0.5, kHigh = 0.9;
  Extent extent;
  if (points.empty()) return extent;
  for (int k = 0; k < 3; ++k) {
    std::vector<float> values;
    for (const Eigen::Vector3f& x : points) values.push_back(x[k]);
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return static_cast<double>(
          values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))]);
    };
    extent.middle[k] = at(kMiddle);
    extent.size[k] = at(kHigh) - at(kLow);
  }
  return extent;
}

double CellSize(const std::vector<Positions>& clouds) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Positions& cloud : clouds) {
    const double size = MeasureExtent(cloud).size.maxCoeff();
    if (size > 0) smallest = std::min(smallest, size);
  }
  return std::isfinite(smallest) ? smallest / kCellsPerCloud : 1;
}

std::string Text(const Eigen::Vector3d& x) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", x.x(), x.y(), x.z());
}

}  // namespace

std::vector<Eigen::Vector3f> SamplePositions(std::span<const Eigen::Vector3f> positions) {
  Positions sample;
  const size_t stride = positions.size() / kSamplePoints + 1;
  for (size_t p = 0; p < positions.size(); p += stride) {
    if (positions[p].allFinite()) sample.push_back(positions[p]);
  }
  return sample;
}

std::vector<double> OverlapShares(const std::vector<Positions>& clouds) {
  const double cell_size = CellSize(clouds);
  const auto cell_of = [&](const Eigen::Vector3f& x) {
    GridCell cell;
    for (int k = 0; k < 3; ++k) cell[k] = std::llround(std::floor(x[k] / cell_size));
    return cell;
  };
  std::map<GridCell, std::set<size_t>> clouds_of;
  for (size_t i = 0; i < clouds.size(); ++i) {
    for (const Eigen::Vector3f& x : clouds[i]) clouds_of[cell_of(x)].insert(i);
  }
  std::vector<double> shares;
  for (const Positions& cloud : clouds) {
    const auto num_shared = std::count_if(cloud.begin(), cloud.end(), [&](const auto& x) {
      return clouds_of.at(cell_of(x)).size() > 1;
    });
    shares.push_back(
        cloud.empty() ? 0 : static_cast<double>(num_shared) / static_cast<double>(cloud.size()));
  }
  return shares;
}

std::string NoOverlapWarning(const std::vector<std::string>& names,
                             const std::vector<Positions>& clouds) {
  const std::vector<double> shares = OverlapShares(clouds);
  if (std::all_of(shares.begin(), shares.end(), [](double s) { return s >= kLeastShare; })) {
    return "";
  }
  std::string text = "some clouds do not overlap with another";
  for (size_t i = 0; i < names.size(); ++i) {
    const Extent extent = MeasureExtent(clouds[i]);
    text += fmt::format(
        "; {}: {:.1f} % of the points lie where another cloud has points, middle "
        "{}, size {}",
        names[i], 100 * shares[i], Text(extent.middle), Text(extent.size));
  }
  return text +
         "; where they should, their models are in different frames: align them first (`colmap "
         "model_merger` or `colmap model_aligner`)";
}

}  // namespace lsmvs
