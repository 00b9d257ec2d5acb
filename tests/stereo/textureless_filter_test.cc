#include "lsmvs/stereo/patch_match/textureless_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lsmvs {
namespace {

constexpr int kSide = 60;
constexpr float kSlope = 1e-3f;

// A plane over the whole image.
PlaneMap SlantedPlane() {
  PlaneMap planes(kSide, kSide);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      planes(column, row) = {1 + kSlope * static_cast<float>(column), kSlope, 0};
    }
  }
  return planes;
}

TEST(PlainZones, TextureIsMeasuredAgainstTheVarianceAsked) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0, 2);
  GrayImage gray(kSide, kSide, 100.0f);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      gray(column, row) +=
          noise(random) + (column < 20 ? ((column + row) % 2 ? 10.0f : -10.0f) : 0);
    }
  }
  const Raster<uint8_t> textured = TexturedPixels(gray, 2, 3 * 2 * 2);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      if (column >= 20 && column < 22) continue;  // windows over both
      EXPECT_EQ(textured(column, row) != 0, column < 20) << column << " " << row;
    }
  }
}

TEST(PlainZones, PlainZoneInsideTextureStays) {
  PlaneMap planes = SlantedPlane();
  Raster<uint8_t> textured(kSide, kSide, 1);
  for (int row = 20; row < 40; ++row) {
    for (int column = 10; column < 50; ++column) textured(column, row) = 0;
  }
  EXPECT_EQ(FilterTexturelessPixels(textured, {.max_deviation = 1e-5f}, &planes), 0u);
}

// A bulge leaves its rim's chord far behind; it hangs together all the same, until there is a gap.
TEST(PlainZones, BulgeStaysWhereItHangsTogether) {
  PlaneMap planes = SlantedPlane();
  Raster<uint8_t> textured(kSide, kSide, 1);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 20; column < 40; ++column) {
      textured(column, row) = 0;
      planes(column, row).q += 0.1f * std::sin((static_cast<float>(column) - 20) / 20 * 3.14159f);
    }
  }
  const TexturelessFilterOptions settings = {.max_deviation = 0.02f, .max_step = 0.02f};
  PlaneMap bulge = planes;
  EXPECT_EQ(FilterTexturelessPixels(textured, settings, &bulge), 0u);
  for (int row = 0; row < kSide; ++row) planes(30, row).q = 0;
  EXPECT_GT(FilterTexturelessPixels(textured, settings, &planes), size_t{10 * kSide});
  EXPECT_EQ(planes(29, 30).q, 0);
  EXPECT_GT(planes(20, 30).q, 0);  // near the chord
}

TEST(PlainZones, DepthCarriedBeyondASilhouetteGoes) {
  PlaneMap planes = SlantedPlane();
  Raster<uint8_t> textured(kSide, kSide, 0);
  for (int row = 30; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) textured(column, row) = 1;
  }
  EXPECT_EQ(FilterTexturelessPixels(textured, {.max_deviation = 1e-2f}, &planes),
            size_t{30 * kSide});
  EXPECT_EQ(planes(5, 29).q, 0);
  EXPECT_GT(planes(5, 30).q, 0);
}

// Windows around the first pixels of the sky reach into the textured wall.
TEST(PlainZones, WindowsWithoutTextureGoWhole) {
  PlaneMap planes = SlantedPlane();
  for (int row = 30; row < kSide; ++row) {
    for (int column = 0; column < 10; ++column) planes(column, row).q = 3;  // nearer: a pole
  }
  Raster<uint8_t> textured(kSide, kSide, 0);
  for (int row = 28; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) textured(column, row) = 1;
  }
  const TexturelessFilterOptions settings = {
      .max_deviation = 1e-2f, .max_step = 1e-2f, .texture_radius = 2};
  FilterTexturelessPixels(textured, settings, &planes);
  EXPECT_EQ(planes(30, 29).q, 0);  // the last row of the last window without texture
  EXPECT_GT(planes(30, 30).q, 0);
  PlaneMap near = SlantedPlane();
  for (int row = 28; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) near(column, row).q = 3;
  }
  FilterTexturelessPixels(textured, settings, &near);
  EXPECT_GT(near(30, 28).q, 0);  // does not continue what went
}

TEST(PlainZones, SkyBetweenTwoDepthsGoes) {
  PlaneMap planes = SlantedPlane();
  Raster<uint8_t> textured(kSide, kSide, 0);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < 20; ++column) textured(column, row) = 1;
    for (int column = 40; column < kSide; ++column) {
      textured(column, row) = 1;
      planes(column, row).q = 3;  // a nearer tower
    }
  }
  // What stands beside the far tower at its depth, as a window that reaches over it would see.
  EXPECT_EQ(FilterTexturelessPixels(textured, {.max_deviation = 1e-2f}, &planes),
            size_t{20 * kSide});
}

TEST(PlainZones, PixelThatLeavesThePlaneAroundItGoes) {
  PlaneMap planes = SlantedPlane();
  Raster<uint8_t> textured(kSide, kSide, 1);
  for (const int column : {30, 33}) textured(column, 30) = 0;
  planes(33, 30).q += 0.1f;
  EXPECT_EQ(FilterTexturelessPixels(textured, {.max_deviation = 1e-2f}, &planes), 1u);
  EXPECT_EQ(planes(33, 30).q, 0);
}

// A plain zone that the border of the image cuts.
TEST(PlainZones, ImageBorderMayHideTheOtherSide) {
  const PlaneMap before = SlantedPlane();
  Raster<uint8_t> textured(kSide, kSide, 1);
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < kSide; ++column) textured(column, row) = 0;
  }
  for (const int reach : {0, 5, 8}) {
    PlaneMap planes = before;
    const TexturelessFilterOptions settings = {.max_deviation = 1e-5f, .border_reach = reach};
    FilterTexturelessPixels(textured, settings, &planes);
    for (int row = 0; row < 8; ++row) EXPECT_EQ(planes(30, row).q > 0, row < reach) << row;
  }
  PlaneMap planes = before;
  planes(30, 2).q += 0.1f;
  const TexturelessFilterOptions settings = {.max_deviation = 1e-2f, .border_reach = 8};
  EXPECT_EQ(FilterTexturelessPixels(textured, settings, &planes), 1u);
}

TEST(PlainZones, AnchorsNeedPlanes) {
  PlaneMap planes = SlantedPlane();
  const Raster<uint8_t> textured(kSide, kSide, 1);
  Raster<uint8_t> plain_zone = textured;
  plain_zone(30, 30) = 0;
  for (auto& plane : planes.pixels) plane.q = 0;
  planes(30, 30).q = 1;
  EXPECT_EQ(FilterTexturelessPixels(plain_zone, {.max_deviation = 1e-2f}, &planes), 1u);
}

}  // namespace
}  // namespace lsmvs
