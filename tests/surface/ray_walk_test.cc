#include "lsmvs/surface/weights/ray_walk.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/surface/tetrahedralization.h"

namespace lsmvs {
namespace {

using Points = std::vector<Eigen::Vector3f>;

Tetrahedralization ComplexOf(const Points& points) {
  Points sorted;
  for (const uint32_t i : HilbertOrder(points)) sorted.push_back(points[i]);
  return BuildDelaunay(std::move(sorted));
}

Points RandomPoints(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  Points points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(uniform(random), uniform(random), uniform(random));
  return points;
}

// Vertices on a grid: rays along its lines and planes run through edges and vertices.
Points GridPoints(int side) {
  Points points;
  for (int i = 0; i < side * side * side; ++i) {
    points.emplace_back(static_cast<float>(i % side), static_cast<float>(i / side % side),
                        static_cast<float>(i / side / side));
  }
  return points;
}

// The stretch of the segment from `a` to `b` inside of a tetrahedron, grown by `slack`: parameters
// in [0, 1]; empty if first > second.
std::pair<double, double> ClipToCell(const Tetrahedralization& complex, const Cell& cell,
                                     const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                     double slack) {
  double low = 0, high = 1;
  for (int k = 0; k < 4; ++k) {
    const auto at = [&](int i) -> Eigen::Vector3d {
      return complex.points[cell.vertex[kFacetVertices[k][i]]].cast<double>();
    };
    const Eigen::Vector3d inward = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    const double from = (a - at(0)).dot(inward) + slack, to = (b - at(0)).dot(inward) + slack;
    if (from < 0 && to < 0) return {1, 0};
    if (from < 0) low = std::max(low, from / (from - to));
    if (to < 0) high = std::min(high, from / (from - to));
  }
  return {low, high};
}

struct Crossing {
  int32_t cell;
  int facet;
  double distance;
};

// Where a walk went.
struct Trace {
  std::vector<int32_t> cells;  // those entered, in order
  std::vector<Crossing> crossings;
  RayWalker::End end;
};

class RayWalkTest : public testing::Test {
 protected:
  void Use(const Points& points) {
    complex_ = ComplexOf(points);
    ASSERT_FALSE(complex_.cells.empty());
  }

  Trace Walk(int32_t vertex, const Eigen::Vector3d& target) const {
    const Eigen::Vector3d way = target - complex_.points[vertex].cast<double>();
    Trace trace;
    trace.end = RayWalker(complex_).Walk(vertex, way.normalized(), way.norm(), 1e9,
                                         [&](int32_t cell, int facet, double distance) {
                                           trace.crossings.push_back({cell, facet, distance});
                                           trace.cells.push_back(cell);
                                         });
    return trace;
  }

  // Against all cells of the complex: the walk meets each cell that the segment is inside of for
  // more than rounding, meets none that is farther away than rounding, and none twice.
  void ExpectAgreesWithOracle(int32_t vertex, const Eigen::Vector3d& target) const {
    const Eigen::Vector3d start = complex_.points[vertex].cast<double>();
    const double length = (target - start).norm(), rounding = 4e-6 * std::max(1.0, length);
    const Trace trace = Walk(vertex, target);
    ASSERT_GE(trace.end.cell, 0);
    ExpectConnected(trace, vertex);
    std::vector<char> met(complex_.cells.size(), 0);
    for (const int32_t c : trace.cells) EXPECT_EQ(met[c]++, 0) << "cell twice";
    for (size_t c = 0; c < complex_.num_finite_cells; ++c) {
      const Cell& cell = complex_.cells[c];
      const auto inside = ClipToCell(complex_, cell, start, target, -rounding);
      const auto near = ClipToCell(complex_, cell, start, target, rounding);
      const bool is_start = std::count(cell.vertex.begin(), cell.vertex.end(), vertex) > 0;
      if (inside.second > inside.first && !is_start) {
        EXPECT_TRUE(met[c]) << "missed";
      }
      if (met[c]) {
        EXPECT_LE(near.first, near.second) << "not on the way";
      }
    }
    ExpectEndsAtTarget(trace, target, rounding);
    for (const Crossing& crossing : trace.crossings)
      EXPECT_LE(crossing.distance, length + rounding);
  }

  // Each cell entered is the neighbour of the one before, through the facet told.
  void ExpectConnected(const Trace& trace, int32_t vertex) const {
    for (size_t i = 0; i < trace.crossings.size(); ++i) {
      const Cell& entered = complex_.cells[trace.crossings[i].cell];
      const int32_t left = entered.neighbor[trace.crossings[i].facet];
      if (i > 0) {
        EXPECT_EQ(left, trace.crossings[i - 1].cell);
      } else {
        const auto& v = complex_.cells[left].vertex;
        EXPECT_TRUE(std::find(v.begin(), v.end(), vertex) != v.end());
      }
    }
    EXPECT_EQ(trace.end.num_crossings, trace.crossings.size());
    if (!trace.cells.empty()) {
      EXPECT_EQ(trace.end.cell, trace.cells.back());
    }
  }

  void ExpectEndsAtTarget(const Trace& trace, const Eigen::Vector3d& target,
                          double rounding) const {
    bool in_hull = false;
    for (size_t c = 0; c < complex_.num_finite_cells; ++c) {
      const auto [low, high] = ClipToCell(complex_, complex_.cells[c], target, target, -rounding);
      in_hull = in_hull || low <= high;
    }
    const bool infinite = complex_.IsInfinite(trace.end.cell);
    if (in_hull) {
      EXPECT_FALSE(infinite);
    }
    if (!infinite) {
      const auto [low, high] =
          ClipToCell(complex_, complex_.cells[trace.end.cell], target, target, rounding);
      EXPECT_LE(low, high);
    }
  }

  int32_t VertexAt(const Eigen::Vector3f& x) const {
    const auto it = std::find(complex_.points.begin(), complex_.points.end(), x);
    return static_cast<int32_t>(it - complex_.points.begin());
  }

  Tetrahedralization complex_;
};

TEST_F(RayWalkTest, TargetsInsideOfTheHull) {
  Use(RandomPoints(300, 1));
  const Points targets = RandomPoints(60, 2);
  for (size_t i = 0; i < targets.size(); ++i) {
    ExpectAgreesWithOracle(static_cast<int32_t>(5 * i), 0.6 * targets[i].cast<double>());
  }
}

TEST_F(RayWalkTest, TargetsOutsideOfTheHull) {
  Use(RandomPoints(300, 3));
  const Points targets = RandomPoints(60, 4);
  for (size_t i = 0; i < targets.size(); ++i) {
    ExpectAgreesWithOracle(static_cast<int32_t>(5 * i),
                           3.0 * targets[i].cast<double>().normalized());
  }
}

TEST_F(RayWalkTest, ThinLayers) {
  Points points = RandomPoints(300, 5);
  for (Eigen::Vector3f& x : points) x.z() *= 1e-3f;
  Use(points);
  for (int32_t v = 0; v < 60; ++v) {
    ExpectAgreesWithOracle(5 * v, {0.1 * (v % 7) - 0.3, 0.1 * (v % 5) - 0.2, 1.0});
    ExpectAgreesWithOracle(5 * v, {2.0, 0.3, 1e-3});
  }
}

// Straight through edges and vertices: along the lines, the diagonals of squares and of cubes, to
// vertices, to middles of edges, and out of the hull through a vertex.
TEST_F(RayWalkTest, ThroughEdgesAndVertices) {
  Use(GridPoints(5));
  const std::vector<Eigen::Vector3d> ways = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1},  {1, 1, 0},
                                             {0, 1, 1}, {1, 1, 1}, {1, -1, 0}, {1, -1, 1},
                                             {2, 1, 0}, {1, 2, 3}, {-1, 0, 0}, {-1, -1, -1}};
  for (const Eigen::Vector3f& from :
       Points{{0, 0, 0}, {2, 2, 2}, {0, 2, 4}, {4, 4, 4}, {1, 0, 3}}) {
    const int32_t vertex = VertexAt(from);
    for (const Eigen::Vector3d& way : ways) {
      for (const double length : {0.5, 1.0, 1.5, 2.0, 20.0}) {
        ExpectAgreesWithOracle(vertex, from.cast<double>() + length * way);
      }
    }
  }
}

// Cameras on the hull: in a facet, on an edge, at a vertex.
TEST_F(RayWalkTest, TargetsOnTheHull) {
  Use(GridPoints(4));
  for (const Eigen::Vector3d& target : std::vector<Eigen::Vector3d>{
           {1.3, 1.6, 3}, {1.5, 3, 3}, {3, 3, 3}, {0, 0.5, 0}, {0, 1.2, 1.7}}) {
    for (size_t v = 0; v < complex_.points.size(); ++v) {
      if ((complex_.points[v].cast<double>() - target).norm() < 1e-9) continue;
      const Trace trace = Walk(static_cast<int32_t>(v), target);
      ASSERT_GE(trace.end.cell, 0);
      ExpectConnected(trace, static_cast<int32_t>(v));
      ExpectEndsAtTarget(trace, target, 1e-5);
    }
  }
}

TEST_F(RayWalkTest, DistancesGrowAndFitTheFacets) {
  Use(RandomPoints(500, 6));
  for (int32_t v = 0; v < 100; ++v) {
    const Eigen::Vector3d target(1.5, 0.2 * (v % 9) - 0.9, 0.3 * (v % 5) - 0.6);
    const Eigen::Vector3d start = complex_.points[v].cast<double>();
    const Eigen::Vector3d direction = (target - start).normalized();
    double last = 0;
    for (const Crossing& crossing : Walk(v, target).crossings) {
      EXPECT_GE(crossing.distance, last - 1e-5);
      last = crossing.distance;
      const Cell& cell = complex_.cells[crossing.cell];
      const auto at = [&](int i) -> Eigen::Vector3d {
        return complex_.points[cell.vertex[kFacetVertices[crossing.facet][i]]].cast<double>();
      };
      if (complex_.IsInfinite(crossing.cell)) continue;
      const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
      const double slope = std::abs(normal.dot(direction));
      EXPECT_LT(std::abs((start + crossing.distance * direction - at(0)).dot(normal)),
                1e-5 + 1e-4 * slope);
    }
  }
}

TEST_F(RayWalkTest, FarDistancesAreNotLessThanNear) {
  Use(RandomPoints(500, 7));
  const RayWalker walker(complex_);
  for (int32_t v = 0; v < 100; ++v) {
    const Eigen::Vector3d way = Eigen::Vector3d(3, 0, 0) - complex_.points[v].cast<double>();
    std::vector<int32_t> careful, quick;
    const auto end =
        walker.Walk(v, way.normalized(), way.norm(), 0.3, [&](int32_t cell, int, double d) {
          quick.push_back(cell);
          EXPECT_GE(d, 0);
        });
    careful = Walk(v, {3, 0, 0}).cells;
    EXPECT_EQ(careful, quick);
    EXPECT_GE(end.cell, 0);
  }
}

}  // namespace
}  // namespace lsmvs
