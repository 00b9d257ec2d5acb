#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace lsmvs {

// Nearest-neighbour search in a cloud. Points that are not finite are left out. Queries are
// thread-safe. Building takes O(P log P). nanoflann's kd-tree.
class ClosestPoints {
 public:
  explicit ClosestPoints(const std::vector<Eigen::Vector3d>& points);
  ~ClosestPoints();
  ClosestPoints(const ClosestPoints&) = delete;
  ClosestPoints& operator=(const ClosestPoints&) = delete;

  // Distance to the nearest point, at most `max_distance`: that is returned where none is nearer.
  double Distance(const Eigen::Vector3d& x, double max_distance) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lsmvs
