#include "lsmvs/image/raster.h"

#include <gtest/gtest.h>

namespace lsmvs {
namespace {

TEST(Raster, IsRowByRow) {
  Raster<int> raster(3, 2, 7);
  EXPECT_EQ(raster.size(), 6u);
  raster(2, 1) = 5;
  raster(0, 1) = 4;
  EXPECT_EQ(raster.pixels, (std::vector<int>{7, 7, 7, 4, 7, 5}));
  EXPECT_EQ(raster.Row(1)[2], 5);
  EXPECT_EQ(raster.Index(2, 1), 5u);
}

TEST(Raster, InsideIsHalfOpen) {
  const Raster<int> raster(3, 2);
  EXPECT_TRUE(raster.Inside(0, 0));
  EXPECT_TRUE(raster.Inside(2, 1));
  EXPECT_FALSE(raster.Inside(3, 1));
  EXPECT_FALSE(raster.Inside(2, 2));
  EXPECT_FALSE(raster.Inside(-1, 0));
  EXPECT_TRUE(Raster<int>().empty());
  EXPECT_EQ(raster(1, 1), 0);
}

}  // namespace
}  // namespace lsmvs
