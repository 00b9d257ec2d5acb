#include "lsmvs/geometry/distances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lsmvs {
namespace {

Eigen::Vector3d RandomPoint(std::mt19937* random) {
  std::uniform_real_distribution<double> number(-1, 1);
  return {number(*random), number(*random), number(*random)};
}

TEST(Distances, OfATriangleAreLeastOverItsPoints) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    const Triangle3 t = {RandomPoint(&random), RandomPoint(&random), RandomPoint(&random)};
    const Eigen::Vector3d p = 2 * RandomPoint(&random);
    const double distance = (ClosestOnTriangle(p, t) - p).norm();
    double least = INFINITY;
    for (int i = 0; i <= 60; ++i) {
      for (int j = 0; i + j <= 60; ++j) {
        const Eigen::Vector3d x = t.a + (t.b - t.a) * (i / 60.0) + (t.c - t.a) * (j / 60.0);
        least = std::min(least, (x - p).norm());
      }
    }
    EXPECT_LE(distance, least + 1e-12);
    EXPECT_GT(distance, least - 0.04);  // the grid's step
  }
}

TEST(Distances, OfADegenerateTriangleAreThoseOfItsSegment) {
  const Triangle3 t = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_NEAR((ClosestOnTriangle({1.5, 3, 0}, t) - Eigen::Vector3d(1.5, 0, 0)).norm(), 0, 1e-12);
  for (const Triangle3& edge :
       {Triangle3{{0, 0, 0}, {0, 0, 0}, {2, 0, 0}}, Triangle3{{0, 0, 0}, {2, 0, 0}, {2, 0, 0}},
        Triangle3{{0, 0, 0}, {2, 0, 0}, {0, 0, 0}}}) {
    EXPECT_NEAR((ClosestOnTriangle({1.5, 3, 0}, edge) - Eigen::Vector3d(1.5, 0, 0)).norm(), 0,
                1e-12);
  }
  const Triangle3 point = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  EXPECT_EQ(ClosestOnTriangle({4, 5, 6}, point), Eigen::Vector3d(1, 1, 1));
}

TEST(Distances, BarycentricCoordinatesGiveThePointBack) {
  std::mt19937 random(3);
  for (int round = 0; round < 100; ++round) {
    const Triangle3 t = {RandomPoint(&random), RandomPoint(&random), RandomPoint(&random)};
    const Eigen::Vector3d p = ClosestOnTriangle(RandomPoint(&random), t);
    const Eigen::Vector3d w = BarycentricCoordinates(p, t);
    EXPECT_NEAR(w.sum(), 1, 1e-12);
    EXPECT_NEAR((w[0] * t.a + w[1] * t.b + w[2] * t.c - p).norm(), 0, 1e-9);
    EXPECT_GT(w.minCoeff(), -1e-9);
  }
  EXPECT_EQ(BarycentricCoordinates({1, 2, 3}, {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}),
            Eigen::Vector3d(1, 0, 0));
}

TEST(Distances, OfAPreparedTriangleAreThoseOfTheTriangle) {
  std::mt19937 random(4);
  for (int round = 0; round < 2000; ++round) {
    const Triangle3 t = {RandomPoint(&random), RandomPoint(&random), RandomPoint(&random)};
    const Eigen::Vector3d p = 2 * RandomPoint(&random);
    const double squared = (ClosestOnTriangle(p, t) - p).squaredNorm();
    EXPECT_NEAR(PreparedTriangle(t).SquaredDistance(p, INFINITY), squared, 1e-9);
    EXPECT_GT(PreparedTriangle(t).SquaredDistance(p, 0.5 * squared), 0.5 * squared);
  }
  const PreparedTriangle flat({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  EXPECT_NEAR(flat.SquaredDistance({1.5, 3, 0}, INFINITY), 9, 1e-12);
  const PreparedTriangle point({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  EXPECT_NEAR(point.SquaredDistance({1, 1, 3}, INFINITY), 4, 1e-12);
}

TEST(Distances, ExitShareIsWhereTheWayLeavesTheTriangle) {
  const PreparedTriangle t({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}});
  EXPECT_NEAR(t.ExitShare({1, 1, 5}, {5, 1, -3}), 0.5, 1e-8);  // at (3, 1)
  EXPECT_NEAR(t.ExitShare({1, 1, 0}, {2, 1, 0}), 1, 1e-12);
  EXPECT_NEAR(t.ExitShare({-1, 1, 0}, {7, 1, 0}), 0.5, 1e-8);
  EXPECT_LT(t.ExitShare({-1, 1, 0}, {-1, 7, 0}), 0);
  EXPECT_LT(t.ExitShare({5, 1, 0}, {1, 5, 0}), 0);
  EXPECT_LT(PreparedTriangle({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).ExitShare({0, 1, 0}, {1, 1, 0}), 0);
}

TEST(Distances, OfASegmentEndAtItsEnds) {
  const Eigen::Vector3d a(0, 0, 0), b(4, 0, 0);
  EXPECT_EQ(ClosestOnSegment({1, 2, 3}, a, b), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(ClosestOnSegment({-1, 2, 3}, a, b), a);
  EXPECT_EQ(ClosestOnSegment({9, 2, 3}, a, b), b);
  EXPECT_EQ(ClosestOnSegment({1, 2, 3}, b, b), b);
}

}  // namespace
}  // namespace lsmvs
