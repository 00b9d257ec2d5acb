#include "lsmvs/texturing/baking/pull_push.h"

#include <gtest/gtest.h>

namespace lsmvs {
namespace {

TEST(PullPush, KeepsWhatIsKnownAndFillsTheRestFromAround) {
  ColorImage colors(37, 21, Color::Zero());
  Raster<uint8_t> coverage(37, 21, uint8_t{0});
  const Color left(200, 10, 10), right(10, 10, 200);
  for (int y = 5; y < 15; ++y) {
    coverage(3, y) = coverage(30, y) = 1;
    colors(3, y) = left;
    colors(30, y) = right;
  }
  PullPush(coverage, &colors);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 37; ++x) {
      EXPECT_GE(colors(x, y)[0], 10);
      EXPECT_LE(colors(x, y)[0], 200);
      EXPECT_EQ(colors(x, y)[1], 10);
    }
  }
  EXPECT_EQ(colors(3, 9), left);
  EXPECT_EQ(colors(2, 9), left);
  EXPECT_EQ(colors(31, 9), right);
}

TEST(PullPush, LeavesAnEmptyPageBlack) {
  ColorImage colors(5, 3, Color::Zero());
  PullPush(Raster<uint8_t>(5, 3, uint8_t{0}), &colors);
  for (const Color& c : colors.pixels) EXPECT_EQ(c, Color(0, 0, 0));
}

}  // namespace
}  // namespace lsmvs
