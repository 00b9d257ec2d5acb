#include "lsmvs/image/hole_filling.h"

#include <gtest/gtest.h>

namespace lsmvs {
namespace {

TEST(HoleFilling, KnownPixelsStayAndTheRestLiesBetweenThem) {
  ColorImage image(37, 23, Color(255, 0, 255));
  ByteImage known(37, 23, 0);
  for (int y = 5; y < 15; ++y) {
    for (int x = 10; x < 20; ++x) {
      image(x, y) = Color(static_cast<uint8_t>(10 * x), 100, static_cast<uint8_t>(5 * y));
      known(x, y) = 1;
    }
  }
  const ColorImage before = image;
  FillHoles(known, &image);
  for (size_t i = 0; i < image.size(); ++i) {
    if (known.pixels[i]) {
      EXPECT_EQ(image.pixels[i], before.pixels[i]);
    } else {
      EXPECT_EQ(image.pixels[i][1], 100);
      EXPECT_GE(image.pixels[i][0], 100);
      EXPECT_LE(image.pixels[i][0], 190);
    }
  }
  // A pixel beside the known ones is like them.
  EXPECT_NEAR(image(20, 10)[0], 190, 15);
  EXPECT_NEAR(image(9, 10)[0], 100, 15);
}

TEST(HoleFilling, NothingKnownIsBlack) {
  ColorImage image(5, 3, Color(9, 9, 9));
  FillHoles(ByteImage(5, 3, 0), &image);
  for (const Color& color : image.pixels) EXPECT_EQ(color, Color(0, 0, 0));
  ColorImage none;
  FillHoles(ByteImage(), &none);
}

}  // namespace
}  // namespace lsmvs
