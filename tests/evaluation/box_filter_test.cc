#include "lsmvs/evaluation/photos/box_filter.h"

#include <gtest/gtest.h>

#include <random>

namespace lsmvs {
namespace {

TEST(WindowSums, AgreeWithTheSlowWay) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 255);
  GrayImage image(23, 17), scratch, mean;
  for (float& value : image.pixels) value = uniform(random);
  const auto mirror = [](int i, int n) { return i < 0 ? -1 - i : i < n ? i : 2 * n - 1 - i; };
  for (const int radius : {0, 1, 4, 16}) {
    BoxMean(image, radius, &scratch, &mean);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        double sum = 0;
        for (int dy = -radius; dy <= radius; ++dy) {
          for (int dx = -radius; dx <= radius; ++dx) {
            sum += image(mirror(x + dx, image.width), mirror(y + dy, image.height));
          }
        }
        ASSERT_NEAR(mean(x, y), sum / ((2 * radius + 1) * (2 * radius + 1)), 1e-3);
      }
    }
  }
}

}  // namespace
}  // namespace lsmvs
