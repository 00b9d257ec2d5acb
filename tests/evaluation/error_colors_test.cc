#include "lsmvs/evaluation/error_colors.h"

#include <gtest/gtest.h>

#include <limits>

namespace lsmvs {
namespace {

double Luminance(const Color& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

TEST(ErrorColors, GrowLighterWithTheError) {
  double last = -1;
  for (int i = 0; i <= 100; ++i) {
    const double luminance = Luminance(ErrorColor(i / 100.0));
    EXPECT_GE(luminance, last);
    last = luminance;
  }
  EXPECT_EQ(ErrorColor(-1), ErrorColor(0));
  EXPECT_EQ(ErrorColor(7), ErrorColor(1));
}

TEST(ErrorColors, UnknownIsGrey) {
  const Color grey = ErrorColor(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(grey[0] == grey[1] && grey[1] == grey[2]);
}

TEST(ErrorColors, AreRelativeToTheLargest) {
  EXPECT_EQ(ErrorColors({0, 2, 4}, 4),
            (std::vector<Color>{ErrorColor(0), ErrorColor(0.5), ErrorColor(1)}));
}

}  // namespace
}  // namespace lsmvs
