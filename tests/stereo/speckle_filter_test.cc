#include "lsmvs/stereo/fusion/speckle_filter.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lsmvs {
namespace {

struct Map {
  Raster<float> depths{40, 30, 5.0f};
  Raster<uint8_t> support{40, 30, kNoSupport};

  void Fill(int left, int top, int width, int height, PixelSupport kind) {
    for (int row = top; row < top + height; ++row) {
      for (int column = left; column < left + width; ++column) support(column, row) = kind;
    }
  }
  int64_t Count(PixelSupport kind) const {
    return std::count(support.pixels.begin(), support.pixels.end(), kind);
  }
  void Drop(int min_area) { FilterSpeckles(depths, 0.01, min_area, &support); }
};

TEST(FilterSpeckles, KeepsAreasThatAreLargeEnough) {
  Map map;
  map.Fill(0, 0, 5, 5, kWeakSupport);
  map.Fill(10, 10, 6, 5, kWeakSupport);
  map.Drop(26);
  EXPECT_EQ(map.Count(kWeakSupport), 30);
  map.Drop(31);
  EXPECT_EQ(map.Count(kWeakSupport), 0);
}

TEST(FilterSpeckles, CountsWhatOthersSupport) {
  Map map;
  map.Fill(0, 0, 2, 2, kWeakSupport);
  map.Fill(2, 0, 10, 10, kSupported);
  map.Fill(38, 0, 2, 2, kWeakSupport);
  map.Fill(36, 0, 2, 25, kCovered);
  map.Drop(50);
  EXPECT_EQ(map.Count(kWeakSupport), 8);
  EXPECT_EQ(map.Count(kSupported), 100);
}

TEST(FilterSpeckles, BridgesOnePixelAndNoMore) {
  Map map;
  map.Fill(0, 0, 3, 3, kWeakSupport);
  map.Fill(4, 0, 3, 3, kWeakSupport);
  map.Fill(20, 20, 3, 3, kWeakSupport);
  map.Fill(25, 20, 3, 3, kWeakSupport);
  map.Drop(18);
  EXPECT_EQ(map.Count(kWeakSupport), 18);
}

TEST(FilterSpeckles, PartsAtStepsOfDepth) {
  Map map;
  map.Fill(0, 0, 10, 10, kWeakSupport);
  for (int row = 0; row < 30; ++row) {
    for (int column = 5; column < 40; ++column) map.depths(column, row) = 5.2f;
  }
  map.Drop(51);
  EXPECT_EQ(map.Count(kWeakSupport), 0);
}

TEST(FilterSpeckles, NeverDropsOtherSupport) {
  Map map;
  map.Fill(3, 3, 1, 1, kSupported);
  map.Fill(9, 9, 1, 1, kCovered);
  map.Drop(100);
  EXPECT_EQ(map.Count(kSupported), 1);
  EXPECT_EQ(map.Count(kCovered), 1);
}

}  // namespace
}  // namespace lsmvs
