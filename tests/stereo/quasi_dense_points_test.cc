#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "lsmvs/stereo/quasi_dense/points.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs::quasi_dense {
namespace {

GrayImage Noise(int width, int height, double deviation, uint64_t seed) {
  GrayImage image(width, height);
  Random random(seed);
  for (float& value : image.pixels) {
    value = static_cast<float>(128 + deviation * random.Gaussian());
  }
  return image;
}

std::vector<InterestPoint> Existing(const PointGrid& grid) {
  std::vector<InterestPoint> points;
  for (const InterestPoint& point : grid.cells.pixels) {
    if (point.exists()) points.push_back(point);
  }
  return points;
}

TEST(QuasiDensePoints, SpacingIsControlled) {
  const GrayImage image = Noise(120, 90, 40, 1);
  for (const float spacing : {1.0f, 2.5f, 4.0f, 7.3f}) {
    const DetectionOptions options{spacing, 2, 4};
    const std::vector<InterestPoint> points =
        Existing(DetectInterestPoints(image, nullptr, options, RunContext(1)));
    const double area = (120 - 8) * (90 - 8);
    // Thinning takes some of the one point a cell.
    EXPECT_GT(static_cast<double>(points.size()), 0.6 * area / (spacing * spacing));
    EXPECT_LT(static_cast<double>(points.size()), 1.2 * area / (spacing * spacing) + 50);
    for (size_t i = 0; i < points.size(); ++i) {
      for (size_t j = 0; j < i; ++j) {
        EXPECT_GE((points[i].position - points[j].position).norm(), 0.5f * spacing - 1e-5f);
      }
    }
  }
}

TEST(QuasiDensePoints, CellsHoldTheirPoints) {
  const PointGrid grid =
      DetectInterestPoints(Noise(101, 77, 40, 2), nullptr, {2.5f, 2, 4}, RunContext(1));
  for (int row = 0; row < grid.cells.height; ++row) {
    for (int column = 0; column < grid.cells.width; ++column) {
      const InterestPoint& point = grid.cells(column, row);
      if (!point.exists()) continue;
      EXPECT_EQ(grid.ColumnOf(point.position.x()), column);
      EXPECT_EQ(grid.RowOf(point.position.y()), row);
    }
  }
}

TEST(QuasiDensePoints, NothingWhereThereIsNoTexture) {
  const DetectionOptions options{2.5f, 2, 4};
  const auto count = [&](const GrayImage& image) {
    return Existing(DetectInterestPoints(image, nullptr, options, RunContext(1))).size();
  };
  EXPECT_EQ(count(GrayImage(64, 64, 128.0f)), 0u);
  EXPECT_EQ(count(GrayImage(6, 5, 128.0f)), 0u);
  // Sensor noise alone makes few points, real texture fills all cells.
  EXPECT_LT(count(Noise(64, 64, 1, 3)), 60u);
  EXPECT_GT(count(Noise(64, 64, 20, 3)), 300u);
}

TEST(QuasiDensePoints, FindsCornersAndBlobs) {
  GrayImage image(64, 64, 50.0f);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 24; ++x) image(x, y) = 200;  // corner at (24, 20)
  }
  for (int y = 43; y < 46; ++y) {
    for (int x = 43; x < 46; ++x) image(x, y) = 200;  // blob around (44.5, 44.5)
  }
  const auto nearest = [&](const Eigen::Vector2f& place) {
    double best = 1e9;
    for (const InterestPoint& point :
         Existing(DetectInterestPoints(image, nullptr, {8, 2, 4}, RunContext(1)))) {
      best = std::min<double>(best, (point.position - place).norm());
    }
    return best;
  };
  EXPECT_LT(nearest({24, 20}), 2.0);
  EXPECT_LT(nearest({44.5f, 44.5f}), 1.5);
}

TEST(QuasiDensePoints, MaskAndBorderHaveNone) {
  ByteImage mask(80, 60, 255);
  for (int y = 0; y < 60; ++y) {
    for (int x = 30; x < 50; ++x) mask(x, y) = 0;
  }
  const std::vector<InterestPoint> points =
      Existing(DetectInterestPoints(Noise(80, 60, 40, 4), &mask, {2, 2, 5}, RunContext(1)));
  EXPECT_GT(points.size(), 100u);
  for (const InterestPoint& point : points) {
    EXPECT_TRUE(point.position.x() < 30 || point.position.x() > 50);
    EXPECT_GT(point.position.minCoeff(), 5);
    EXPECT_LT(point.position.x(), 75);
    EXPECT_LT(point.position.y(), 55);
  }
}

TEST(QuasiDensePoints, SameForAnyNumberOfThreads) {
  const GrayImage image = Noise(200, 190, 30, 5);
  const PointGrid one = DetectInterestPoints(image, nullptr, {2.5f, 2, 4}, RunContext(1));
  const PointGrid three = DetectInterestPoints(image, nullptr, {2.5f, 2, 4}, RunContext(3));
  for (size_t i = 0; i < one.cells.size(); ++i) {
    EXPECT_EQ(one.cells.pixels[i].position, three.cells.pixels[i].position);
  }
}

TEST(QuasiDensePoints, KeypointsReplaceThePointsOfTheirCells) {
  const DetectionOptions options{4, 2, 4};
  PointGrid grid = DetectInterestPoints(GrayImage(40, 30, 99.0f), nullptr, options, RunContext(1));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ByteImage mask(40, 30, 255);
  mask(31, 21) = 0;
  // In a photo twice as large: two in one cell, two outside, one masked, one not finite.
  const std::vector<Eigen::Vector2f> keypoints = {
      {20.5f, 21.25f}, {21.0f, 21.5f}, {2, 20}, {500, 20}, {63, 43}, {nan, 20}, {50, 30}};
  EXPECT_EQ(JoinKeypoints(keypoints, {0.5f, 0.5f}, {40, 30}, &mask, options, &grid), 2u);
  const std::vector<InterestPoint> points = Existing(grid);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].position, Eigen::Vector2f(10.25f, 10.625f));
  EXPECT_EQ(points[1].position, Eigen::Vector2f(25, 15));
}

TEST(QuasiDensePoints, VisitsTheCellsAround) {
  PointGrid grid;
  grid.spacing = 2;
  grid.cells = Raster<InterestPoint>(6, 5);
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 6; ++column) {
      grid.cells(column, row).position = {2.0f * static_cast<float>(column) + 1,
                                          2.0f * static_cast<float>(row) + 1};
    }
  }
  const auto count = [&](float x, float y, int reach) {
    int visited = 0;
    ForPointsAround(grid, {x, y}, reach, [&](const InterestPoint&) { ++visited; });
    return visited;
  };
  EXPECT_EQ(count(5, 5, 1), 9);
  EXPECT_EQ(count(0.1f, 0.1f, 1), 4);
  EXPECT_EQ(count(11.9f, 9.9f, 2), 9);
  EXPECT_EQ(count(5, 5, 100), 30);
}

}  // namespace
}  // namespace lsmvs::quasi_dense
