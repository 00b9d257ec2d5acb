#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <limits>
#include <vector>

#include "lsmvs/stereo/quasi_dense/window.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs::quasi_dense {
namespace {

GrayImage RandomImage(int width, int height, uint64_t seed) {
  GrayImage image(width, height);
  Random random(seed);
  for (float& value : image.pixels) value = static_cast<float>(random.Below(256));
  return image;
}

WindowWarp RandomWarp(Random* random) {
  WindowWarp warp;
  warp.x = static_cast<float>(random->Uniform(12, 50));
  warp.y = static_cast<float>(random->Uniform(12, 36));
  warp.xx = static_cast<float>(random->Uniform(0.5, 1.5));
  warp.yy = static_cast<float>(random->Uniform(0.5, 1.5));
  warp.xy = static_cast<float>(random->Uniform(-0.5, 0.5));
  warp.yx = static_cast<float>(random->Uniform(-0.5, 0.5));
  return warp;
}

// The obvious bilinear sample, in double.
double Sample(const GrayImage& image, double x, double y) {
  const int column = static_cast<int>(std::floor(x - 0.5)),
            row = static_cast<int>(std::floor(y - 0.5));
  const double a = x - 0.5 - column, b = y - 0.5 - row;
  return (1 - b) * ((1 - a) * image(column, row) + a * image(column + 1, row)) +
         b * ((1 - a) * image(column, row + 1) + a * image(column + 1, row + 1));
}

std::vector<double> Samples(const GrayImage& image, const WindowPattern& pattern,
                            const WindowWarp& warp) {
  std::vector<double> samples;
  for (int k = 0; k < pattern.num_samples; ++k) {
    const double dx = pattern.dx[k], dy = pattern.dy[k];
    samples.push_back(
        Sample(image, warp.x + warp.xx * dx + warp.xy * dy, warp.y + warp.yx * dx + warp.yy * dy));
  }
  return samples;
}

double WeightedZncc(const WindowPattern& pattern, const std::vector<double>& a,
                    const std::vector<double>& b) {
  double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    mean_a += pattern.weight[k] * a[k];
    mean_b += pattern.weight[k] * b[k];
  }
  for (size_t k = 0; k < a.size(); ++k) {
    aa += pattern.weight[k] * (a[k] - mean_a) * (a[k] - mean_a);
    bb += pattern.weight[k] * (b[k] - mean_b) * (b[k] - mean_b);
    ab += pattern.weight[k] * (a[k] - mean_a) * (b[k] - mean_b);
  }
  return ab / std::sqrt(aa * bb);
}

WindowWarp At(float x, float y) {
  WindowWarp warp;
  warp.x = x;
  warp.y = y;
  return warp;
}

TEST(QuasiDenseWindow, PatternIsASquareWithoutCorners) {
  for (int radius = 1; radius <= kMaxWindowRadius; ++radius) {
    const WindowPattern pattern = MakeWindowPattern(radius);
    const int side = 2 * radius + 1;
    float total = 0;
    int count = 0;
    for (int k = 0; k < pattern.num_samples; ++k) {
      total += pattern.weight[k];
      if (pattern.weight[k] > 0) ++count;
      EXPECT_LE(std::abs(pattern.dx[k]), static_cast<float>(radius));
    }
    EXPECT_EQ(count, side * side - 4);
    EXPECT_EQ(pattern.num_samples % 16, 0);
    EXPECT_LE(pattern.num_samples, kMaxWindowSamples);
    EXPECT_NEAR(total, 1, 1e-5);
  }
}

TEST(QuasiDenseWindow, EqualsTheObviousZncc) {
  const GrayImage a = RandomImage(64, 48, 1), b = RandomImage(64, 48, 2);
  const PackedImage cells_a = PackedImage(a), cells_b = PackedImage(b);
  Random random(3);
  for (const int radius : {1, 3, 5, 7}) {
    const WindowPattern pattern = MakeWindowPattern(radius);
    for (int trial = 0; trial < 200; ++trial) {
      const WindowWarp warp_a = RandomWarp(&random), warp_b = RandomWarp(&random);
      if (!WindowInside(cells_a, pattern, warp_a) || !WindowInside(cells_b, pattern, warp_b)) {
        continue;
      }
      ReferenceWindow reference;
      ReadReferenceWindow(cells_a, pattern, warp_a, &reference);
      EXPECT_NEAR(CompareWindow(cells_b, pattern, warp_b, reference),
                  WeightedZncc(pattern, Samples(a, pattern, warp_a), Samples(b, pattern, warp_b)),
                  2e-4);
    }
  }
}

TEST(QuasiDenseWindow, IgnoresGainAndOffset) {
  GrayImage image = RandomImage(32, 32, 5);
  const WindowPattern pattern = MakeWindowPattern(3);
  ReferenceWindow reference;
  ReadReferenceWindow(PackedImage(image), pattern, At(16.5f, 16.5f), &reference);
  EXPECT_NEAR(CompareWindow(PackedImage(image), pattern, At(16.5f, 16.5f), reference), 1, 1e-5);
  for (float& value : image.pixels) value = 0.5f * value + 60;
  EXPECT_NEAR(CompareWindow(PackedImage(image), pattern, At(16.5f, 16.5f), reference), 1, 1e-3);
  for (float& value : image.pixels) value = 255 - value;
  EXPECT_NEAR(CompareWindow(PackedImage(image), pattern, At(16.5f, 16.5f), reference), -1, 1e-3);
}

TEST(QuasiDenseWindow, FlatWindowsMatchNothing) {
  const PackedImage flat = PackedImage(GrayImage(32, 32, 77.0f));
  const PackedImage textured = PackedImage(RandomImage(32, 32, 5));
  const WindowPattern pattern = MakeWindowPattern(3);
  ReferenceWindow reference;
  ReadReferenceWindow(flat, pattern, At(16, 16), &reference);
  EXPECT_LT(reference.deviation, 1e-2);
  EXPECT_NEAR(CompareWindow(textured, pattern, At(16, 16), reference), 0, 1e-3);
  ReadReferenceWindow(textured, pattern, At(16, 16), &reference);
  EXPECT_EQ(CompareWindow(flat, pattern, At(16, 16), reference), 0);
}

TEST(QuasiDenseWindow, DeviationIsThatOfTheGreyValues) {
  GrayImage image(32, 32);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) image(x, y) = (x + y) % 2 == 0 ? 90.0f : 110.0f;
  }
  ReferenceWindow reference;
  ReadReferenceWindow(PackedImage(image), MakeWindowPattern(3), At(16.5f, 16.5f), &reference);
  EXPECT_NEAR(reference.mean, 100, 1);
  EXPECT_NEAR(reference.deviation, 10, 0.1);
}

// At the very border no pixel beyond the image is read (the sanitizers watch).
TEST(QuasiDenseWindow, BorderIsInside) {
  const PackedImage cells = PackedImage(RandomImage(20, 10, 9));
  const WindowPattern pattern = MakeWindowPattern(3);
  ReferenceWindow reference;
  ReadReferenceWindow(cells, pattern, At(10, 5), &reference);
  for (const float x : {3.51f, 10.0f, 16.49f}) {
    for (const float y : {3.51f, 5.0f, 6.49f}) {
      ASSERT_TRUE(WindowInside(cells, pattern, At(x, y)));
      EXPECT_TRUE(std::isfinite(CompareWindow(cells, pattern, At(x, y), reference)));
    }
  }
  EXPECT_FALSE(WindowInside(cells, pattern, At(3.4f, 5)));
  EXPECT_FALSE(WindowInside(cells, pattern, At(16.6f, 5)));
  EXPECT_FALSE(WindowInside(cells, pattern, At(10, 6.6f)));
  EXPECT_FALSE(WindowInside(cells, pattern, At(std::numeric_limits<float>::quiet_NaN(), 5)));
  EXPECT_FALSE(WindowInside(cells, pattern, At(1e30f, 5)));
}

TEST(QuasiDenseWindow, SameValueOnEveryInstructionSet) {
  const PackedImage a = PackedImage(RandomImage(64, 48, 1)),
                    b = PackedImage(RandomImage(64, 48, 2));
  const WindowPattern pattern = MakeWindowPattern(4);
  std::vector<WindowWarp> warps;
  Random random(7);
  while (warps.size() < 50) {
    const WindowWarp warp = RandomWarp(&random);
    if (WindowInside(a, pattern, warp)) warps.push_back(warp);
  }
  std::vector<float> first;
  for (int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets & -targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    std::vector<float> values;
    for (const WindowWarp& warp : warps) {
      ReferenceWindow reference;
      ReadReferenceWindow(a, pattern, warp, &reference);
      values.push_back(CompareWindow(b, pattern, warps.front(), reference));
    }
    if (first.empty()) first = values;
    EXPECT_EQ(values, first);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace
}  // namespace lsmvs::quasi_dense
