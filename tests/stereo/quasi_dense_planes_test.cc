#include "lsmvs/stereo/quasi_dense/planes.h"

#include <gtest/gtest.h>

#include <functional>

#include "lsmvs/synthetic/random.h"

namespace lsmvs::quasi_dense {
namespace {

constexpr float kTolerance = 1e-3f;

// A full grid of points whose inverse depth is a function of the position.
PointGrid MakeGrid(const std::function<float(const Eigen::Vector2f&)>& inverse_depth) {
  PointGrid grid;
  grid.spacing = 2.5f;
  grid.cells = Raster<InterestPoint>(12, 12);
  Random random(1);
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) {
      InterestPoint& point = grid.cells(column, row);
      point.position = 2.5f * Eigen::Vector2f(static_cast<float>(column + random.Uniform()),
                                              static_cast<float>(row + random.Uniform()));
      point.plane.q = inverse_depth(point.position);
    }
  }
  return grid;
}

float OnPlane(const Eigen::Vector2f& position) {
  return 0.4f + 2e-3f * (position.x() - 15) - 1e-3f * (position.y() - 15);
}

TEST(QuasiDensePlanes, ExactOnAPlane) {
  const PointGrid grid = MakeGrid(OnPlane);
  const Plane fit = FitPlane(grid, {15, 15}, {0.4f, 0, 0}, 10 * kTolerance, 2);
  EXPECT_NEAR(fit.q, 0.4f, 1e-5);
  EXPECT_NEAR(fit.qx, 2e-3f, 1e-5);
  EXPECT_NEAR(fit.qy, -1e-3f, 1e-5);
}

TEST(QuasiDensePlanes, OutliersDoNotBend) {
  Random random(2);
  const PointGrid grid = MakeGrid([&](const Eigen::Vector2f& position) {
    return OnPlane(position) +
           (random.Uniform() < 0.25 ? static_cast<float>(random.Uniform(0.05, 0.3)) : 0.0f);
  });
  const Plane fit = FitPlane(grid, {15, 15}, {OnPlane({15, 15}), 2e-3f, -1e-3f}, kTolerance, 2);
  EXPECT_NEAR(fit.q, 0.4f, 0.3 * kTolerance);
  EXPECT_NEAR(fit.qx, 2e-3f, 0.2 * kTolerance);
  EXPECT_NEAR(fit.qy, -1e-3f, 0.2 * kTolerance);
}

TEST(QuasiDensePlanes, StopsAtAnEdgeOfDepth) {
  const PointGrid grid =
      MakeGrid([](const Eigen::Vector2f& position) { return position.x() < 15 ? 0.4f : 0.6f; });
  const Plane fit = FitPlane(grid, {14, 15}, {0.4f, 0, 0}, kTolerance, 2);
  EXPECT_NEAR(fit.q, 0.4f, 0.3 * kTolerance);
  EXPECT_NEAR(fit.qx, 0, 0.1 * kTolerance);
}

TEST(QuasiDensePlanes, TooFewPointsLeaveTheGuess) {
  PointGrid grid = MakeGrid(OnPlane);
  int kept = 0;
  for (InterestPoint& point : grid.cells.pixels) {
    if (++kept > 4) point.plane = Plane();
  }
  const Plane fit = FitPlane(grid, {3, 3}, {0.7f, 1e-3f, 0}, kTolerance, 3);
  EXPECT_EQ(fit.q, 0.7f);
  EXPECT_EQ(fit.qx, 1e-3f);
}

TEST(QuasiDensePlanes, PointsInALineLeaveTheGuess) {
  PointGrid grid = MakeGrid(OnPlane);
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) {
      InterestPoint& point = grid.cells(column, row);
      if (row != 5) {
        point.plane = Plane();
      } else {
        point.position.y() = 13;
      }
    }
  }
  const Plane fit = FitPlane(grid, {15, 13}, {0.4f, 0, 7e-3f}, kTolerance, 3);
  EXPECT_EQ(fit.qy, 7e-3f);
}

}  // namespace
}  // namespace lsmvs::quasi_dense
