#include "lsmvs/geometry/hilbert_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace lsmvs {
namespace {

using testing::ElementsAre;
using Points = std::vector<Eigen::Vector3d>;

TEST(HilbertOrder, NextCellsOfAGridTouch) {
  Points points;
  constexpr int kSide = 16;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) points.emplace_back(x + 0.5, y + 0.5, z + 0.5);
    }
  }
  // The corners of the box make the curve's cells those of the grid.
  points.emplace_back(0, 0, 0);
  points.emplace_back(kSide, kSide, kSide);
  std::vector<uint32_t> order = HilbertOrder(points);
  std::erase_if(order, [](uint32_t i) { return i >= kSide * kSide * kSide; });
  ASSERT_EQ(order.size(), static_cast<size_t>(kSide * kSide * kSide));
  for (size_t i = 1; i < order.size(); ++i) {
    ASSERT_DOUBLE_EQ((points[order[i]] - points[order[i - 1]]).norm(), 1.0) << i;
  }
}

TEST(HilbertOrder, TiesKeepTheirOrder) {
  EXPECT_THAT(HilbertOrder(Points(3, Eigen::Vector3d(1, 2, 3))), ElementsAre(0, 1, 2));
  EXPECT_TRUE(HilbertOrder(Points()).empty());
}

TEST(HilbertOrder, IsAPermutationWhateverTheNumbers) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Points points = {{1, 0, 0}, {kNan, 1, 2}, {0, 1, 0}, {3, kNan, kNan}};
  EXPECT_THAT(HilbertOrder(points), testing::UnorderedElementsAre(0, 1, 2, 3));
}

}  // namespace
}  // namespace lsmvs
