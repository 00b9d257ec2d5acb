#include "lsmvs/scene/center_groups.h"

#include <algorithm>

#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

constexpr double kSamePlace = 1e-4;

// Median distance of the centres from their median.
double Spread(const std::vector<Eigen::Vector3d>& centers) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& center : centers) values.push_back(center[axis]);
    median[axis] = Median(&values);
  }
  std::vector<double> distances;
  for (const Eigen::Vector3d& center : centers) distances.push_back((center - median).norm());
  return Median(&distances);
}

}  // namespace

std::vector<int> CenterGroups(const Scene& scene) {
  std::vector<Eigen::Vector3d> centers, places;
  for (const View& view : scene.views) centers.push_back(view.CenterInWorld());
  const double tolerance = centers.empty() ? 0 : kSamePlace * Spread(centers);
  std::vector<int> groups;
  for (const Eigen::Vector3d& center : centers) {
    const auto near = [&](const Eigen::Vector3d& place) {
      return (place - center).norm() <= tolerance;
    };
    const auto found = std::find_if(places.begin(), places.end(), near);
    groups.push_back(static_cast<int>(found - places.begin()));
    if (found == places.end()) places.push_back(center);
  }
  return groups;
}

}  // namespace lsmvs
