#include "lsmvs/texturing/candidates/photo_validity.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "lsmvs/texturing/candidates/sharpness_map.h"

namespace lsmvs {
namespace {

constexpr PinholeCamera kCamera = {60, 40, 50, 50, 30, 20};

class PhotoValidity : public testing::Test {
 protected:
  Raster<float> depth_{60, 40, 2.0f};
  ColorImage colors_{60, 40, Color(50, 60, 70)};

  Raster<uint8_t> Find(const ByteImage* mask = nullptr) const {
    return FindValidPixels(kCamera, depth_, colors_, mask);
  }
};

TEST_F(PhotoValidity, EndsBeforeTheBorder) {
  const auto validity = Find();
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      const bool inside = x >= 4 && y >= 4 && x < 56 && y < 36;
      EXPECT_EQ(validity(x, y), inside ? kValidPixel : kInvalidPixel);
    }
  }
}

TEST_F(PhotoValidity, DoubtsTheFarSideOfAnEdge) {
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 30; ++x) depth_(x, y) = 1.0f;
  }
  const auto validity = Find();
  for (int x = 4; x < 56; ++x) {
    EXPECT_EQ(validity(x, 20), x >= 30 && x <= 32 ? kDoubtfulPixel : kValidPixel) << x;
  }
}

TEST_F(PhotoValidity, TrustsASlantedPlane) {
  // 75 degrees: the depth grows by 3.7 pixels' widths per pixel.
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) depth_(x, y) = 1.0f / (0.6f - 0.0066f * static_cast<float>(x));
  }
  const auto validity = Find();
  EXPECT_EQ(validity(10, 20), kValidPixel);
  EXPECT_EQ(validity(30, 20), kValidPixel);
}

TEST_F(PhotoValidity, LeavesOutTheMaskAndWhatLiesBeside) {
  ByteImage mask(60, 40, uint8_t{255});
  mask(30, 20) = 0;
  const auto validity = Find(&mask);
  EXPECT_EQ(validity(33, 23), kInvalidPixel);
  EXPECT_EQ(validity(34, 20), kValidPixel);
}

TEST_F(PhotoValidity, LeavesOutTheBlackRimButNotBlackThings) {
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 10; ++x) colors_(x, y) = Color::Zero();
  }
  colors_(40, 20) = Color::Zero();
  const auto validity = Find();
  EXPECT_EQ(validity(11, 20), kInvalidPixel);
  EXPECT_EQ(validity(12, 20), kValidPixel);
  EXPECT_EQ(validity(40, 20), kValidPixel);
}

TEST_F(PhotoValidity, IsNowhereWithoutSurface) {
  depth_(20, 20) = 0;
  EXPECT_EQ(Find()(20, 20), kInvalidPixel);
}

TEST(SharpnessMap, FallsWithBlurAndNotWithContrast) {
  const auto ratio = [](double wavelength, double contrast) {
    ColorImage image(64, 64);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double value = 128 + contrast * std::sin(2 * 3.14159265 * (x + 0.3 * y) / wavelength);
        image(x, y) = Color::Constant(static_cast<uint8_t>(value));
      }
    }
    return static_cast<int>(SharpnessMap(image).At(32, 32));
  };
  EXPECT_GT(2 * ratio(4, 100), 3 * ratio(20, 100));
  EXPECT_NEAR(ratio(4, 100), ratio(4, 50), 8);
}

}  // namespace
}  // namespace lsmvs
