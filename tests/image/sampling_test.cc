#include "lsmvs/image/sampling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lsmvs {
namespace {

GrayImage Wavy(int width, int height) {
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = static_cast<float>(100 + 50 * std::sin(0.9 * x + 0.3 * y) + 7.0 * (x * y % 5));
    }
  }
  return image;
}

TEST(SampleBilinear, IsThePixelAtPixelCentres) {
  const GrayImage image = Wavy(7, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) {
      ASSERT_TRUE(InsideForSampling(image, x + 0.5, y + 0.5));
      EXPECT_FLOAT_EQ(SampleBilinear(image, x + 0.5, y + 0.5).value, image(x, y));
    }
  }
}

TEST(SampleBilinear, ReproducesPlanesAndTheirSlope) {
  GrayImage image(8, 6);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      image(x, y) = static_cast<float>(3 + 2 * (x + 0.5) - 1.5 * (y + 0.5));
    }
  }
  for (const Eigen::Vector2d& x : {Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(3.3, 4.7),
                                   Eigen::Vector2d(7.5, 5.5), Eigen::Vector2d(7.49, 0.51)}) {
    const BilinearSample sample = SampleBilinear(image, x.x(), x.y());
    EXPECT_NEAR(sample.value, 3 + 2 * x.x() - 1.5 * x.y(), 1e-5);
    EXPECT_NEAR(sample.gradient.x(), 2.0f, 1e-5f);
    EXPECT_NEAR(sample.gradient.y(), -1.5f, 1e-5f);
  }
}

TEST(SampleBilinear, GradientIsTheDerivativeOfTheInterpolant) {
  const GrayImage image = Wavy(9, 9);
  constexpr double kStep = 1e-2;
  for (double y = 1.03; y < 8; y += 0.51) {
    for (double x = 1.07; x < 8; x += 0.47) {
      // Not across the border of two cells.
      const auto cell = [](double v) { return std::floor(v - 0.5); };
      if (cell(x - kStep) != cell(x + kStep) || cell(y - kStep) != cell(y + kStep)) continue;
      const auto value = [&](double dx, double dy) {
        return SampleBilinear(image, x + dx, y + dy).value;
      };
      const BilinearSample sample = SampleBilinear(image, x, y);
      EXPECT_NEAR((value(kStep, 0) - value(-kStep, 0)) / (2 * kStep), sample.gradient.x(), 5e-3);
      EXPECT_NEAR((value(0, kStep) - value(0, -kStep)) / (2 * kStep), sample.gradient.y(), 5e-3);
    }
  }
}

TEST(InsideForSampling, EndsAtTheOuterPixelCentres) {
  const GrayImage image(4, 3);
  EXPECT_TRUE(InsideForSampling(image, 0.5, 2.5));
  EXPECT_TRUE(InsideForSampling(image, 3.5, 0.5));
  EXPECT_FALSE(InsideForSampling(image, 3.5001, 1));
  EXPECT_FALSE(InsideForSampling(image, 1, 0.4999));
  EXPECT_FALSE(InsideForSampling(image, std::nan(""), 1));
}

}  // namespace
}  // namespace lsmvs
