#include "lsmvs/evaluation/samples/closest_points.h"

#include <cmath>
#include <nanoflann.hpp>

namespace lsmvs {

namespace {

struct FinitePoints {
  std::vector<Eigen::Vector3d> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(size_t i, size_t k) const { return points[i][static_cast<int>(k)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, FinitePoints>,
                                                 FinitePoints, 3>;

FinitePoints KeepFinite(const std::vector<Eigen::Vector3d>& points) {
  FinitePoints result;
  result.points.reserve(points.size());
  for (const Eigen::Vector3d& x : points) {
    if (x.allFinite()) result.points.push_back(x);
  }
  return result;
}

}  // namespace

struct ClosestPoints::State {
  explicit State(const std::vector<Eigen::Vector3d>& all)
      : finite(KeepFinite(all)), tree(3, finite) {}
  FinitePoints finite;
  Tree tree;
};

ClosestPoints::ClosestPoints(const std::vector<Eigen::Vector3d>& points)
    : state_(std::make_unique<State>(points)) {}

ClosestPoints::~ClosestPoints() = default;

double ClosestPoints::Distance(const Eigen::Vector3d& x, double max_distance) const {
  if (state_->finite.points.empty()) return max_distance;
  size_t index = 0;
  double squared_distance = max_distance * max_distance;
  nanoflann::KNNResultSet<double> result(1);
  result.init(&index, &squared_distance);
  state_->tree.findNeighbors(result, x.data(), nanoflann::SearchParams());
  return std::min(std::sqrt(squared_distance), max_distance);
}

}  // namespace lsmvs
