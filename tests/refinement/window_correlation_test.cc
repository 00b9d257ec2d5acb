#include "lsmvs/refinement/photo/window_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace lsmvs {
namespace {

// A tile of smooth random texture; the other view's is a distorted copy with gain and offset.
CorrelationTile MakeTile(int width, int height, double missing_fraction, unsigned seed) {
  CorrelationTile tile;
  tile.Resize(width, height);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const size_t at = static_cast<size_t>(y * width + x);
      const float wave =
          40.0f * std::sin(0.7f * static_cast<float>(x)) * std::cos(0.5f * static_cast<float>(y));
      tile.reference[at] = 110 + wave + 20 * uniform(random);
      tile.warped[at] = 60 + 0.8f * wave + 20 * uniform(random);
      tile.valid[at] = uniform(random) < missing_fraction ? 0.0f : 1.0f;
      tile.weight[at] = uniform(random) < 0.2f ? 0.0f : 1.0f;
    }
  }
  return tile;
}

void Correlate(const CorrelationOptions& options, CorrelationTile* tile) {
  CorrelationScratch scratch;
  tile->FindSpans(options.radius);
  CorrelateWindows(options, &scratch, tile);
}

// The definition, window by window, in double precision.
std::vector<double> SlowErrors(const CorrelationTile& tile, const CorrelationOptions& options) {
  std::vector<double> errors(static_cast<size_t>(tile.width * tile.height), 0.0);
  const int r = options.radius;
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
      for (int v = std::max(0, y - r); v <= std::min(tile.height - 1, y + r); ++v) {
        for (int u = std::max(0, x - r); u <= std::min(tile.width - 1, x + r); ++u) {
          const size_t k = static_cast<size_t>(v * tile.width + u);
          if (tile.valid[k] == 0) continue;
          const double p = tile.reference[k], q = tile.warped[k];
          n += 1, a += p, b += q, aa += p * p, bb += q * q, ab += p * q;
        }
      }
      const size_t at = static_cast<size_t>(y * tile.width + x);
      if (n < options.min_valid_fraction * static_cast<float>((2 * r + 1) * (2 * r + 1))) continue;
      const double va = aa / n - a * a / n / n + options.noise_variance;
      const double vb = bb / n - b * b / n / n + options.noise_variance;
      const double zncc = (ab / n - a * b / n / n) / std::sqrt(va * vb);
      const double signal = va - options.noise_variance, h = 1 - zncc, s = options.robust_scale;
      const double texture = signal / (signal + 4 * options.noise_variance);
      errors[at] = tile.weight[at] * tile.valid[at] * texture * h * s / (h + s);
    }
  }
  return errors;
}

double Total(const std::vector<double>& errors) {
  double sum = 0;
  for (const double error : errors) sum += error;
  return sum;
}

TEST(WindowCorrelation, AgreesWithTheDefinition) {
  for (const int radius : {1, 2, 3, 7}) {
    for (const int width : {5, 16, 37}) {
      CorrelationTile tile = MakeTile(width, 23, 0.15, 7);
      const CorrelationOptions options{radius, 4.0f, 0.5f, 0.4f};
      Correlate(options, &tile);
      const std::vector<double> slow = SlowErrors(tile, options);
      for (size_t k = 0; k < slow.size(); ++k) {
        ASSERT_NEAR(tile.error[k], slow[k], 2e-4) << "radius " << radius << " pixel " << k;
      }
    }
  }
}

TEST(WindowCorrelation, DerivativeAgreesWithFiniteDifferencesAtEveryPixel) {
  CorrelationTile tile = MakeTile(21, 18, 0.1, 3);
  const CorrelationOptions options{2, 2.0f, 0.5f, 0.5f};
  Correlate(options, &tile);
  const double step = 0.01;
  for (size_t k = 0; k < static_cast<size_t>(tile.width * tile.height); ++k) {
    CorrelationTile up = tile, down = tile;
    up.warped[k] += static_cast<float>(step);
    down.warped[k] -= static_cast<float>(step);
    const double width = static_cast<double>(up.warped[k]) - down.warped[k];
    const double numeric =
        (Total(SlowErrors(up, options)) - Total(SlowErrors(down, options))) / width;
    ASSERT_NEAR(tile.derivative[k], numeric, 1e-5 + 1e-3 * std::abs(numeric)) << "pixel " << k;
  }
}

TEST(WindowCorrelation, GainAndOffsetOfAPhotoChangeNothing) {
  CorrelationTile tile = MakeTile(40, 30, 0.0, 5);
  const CorrelationOptions options{3, 1e-4f, 0.5f, 0.5f};
  Correlate(options, &tile);
  const std::vector<float> before = tile.error;
  for (float& value : tile.warped) value = 0.7f * value + 30;
  Correlate(options, &tile);
  for (size_t k = 0; k < 40 * 30; ++k) ASSERT_NEAR(tile.error[k], before[k], 1e-3);
}

TEST(WindowCorrelation, IdenticalWindowsHaveNoErrorAndFlatOnesLittleCurvature) {
  CorrelationTile tile = MakeTile(30, 20, 0.0, 9);
  tile.warped = tile.reference;
  for (float& weight : tile.weight) weight = 1;
  const CorrelationOptions options{3, 4.0f, 0.5f, 0.5f};
  Correlate(options, &tile);
  for (size_t k = 0; k < 30 * 20; ++k) {
    ASSERT_LT(tile.error[k], 0.06f);
    ASSERT_NEAR(tile.derivative[k], 0, 3e-3);
    ASSERT_GE(tile.curvature[k], 0);
  }
}

// Few judged pixels, and nothing known where no window of theirs reaches.
TEST(WindowCorrelation, WhatNoJudgedWindowReachesDoesNotMatter) {
  CorrelationTile tile = MakeTile(61, 50, 0.1, 11);
  std::mt19937 random(2);
  for (float& weight : tile.weight) weight = random() % 400 == 0 ? 1.0f : 0.0f;
  const CorrelationOptions options{3, 4.0f, 0.5f, 0.4f};
  Correlate(options, &tile);
  const std::vector<double> slow = SlowErrors(tile, options);
  CorrelationTile other = tile;
  int num_unknown = 0;
  for (int row = 0; row < tile.height; ++row) {
    const ColumnSpan& reached = tile.reached[static_cast<size_t>(row)];
    for (int x = 0; x < tile.width; ++x) {
      if (x >= reached.begin && x < reached.end) continue;
      const size_t at = static_cast<size_t>(row * tile.width + x);
      other.reference[at] = other.warped[at] = other.valid[at] = NAN;
      ++num_unknown;
    }
  }
  ASSERT_GT(num_unknown, 100);
  Correlate(options, &other);
  for (size_t k = 0; k < slow.size(); ++k) {
    ASSERT_NEAR(other.error[k], slow[k], 2e-4) << k;
    ASSERT_EQ(other.error[k], tile.error[k]) << k;
    ASSERT_EQ(other.mass[k], tile.mass[k]) << k;
    ASSERT_EQ(other.derivative[k], tile.derivative[k]) << k;
    ASSERT_EQ(other.curvature[k], tile.curvature[k]) << k;
  }
}

TEST(WindowCorrelation, ErrorsAreTheSameWithoutDerivatives) {
  CorrelationTile tile = MakeTile(45, 31, 0.1, 12), errors_only = tile;
  CorrelationOptions options{3, 4.0f, 0.5f, 0.4f};
  Correlate(options, &tile);
  options.derivatives = false;
  Correlate(options, &errors_only);
  for (size_t k = 0; k < 45 * 31; ++k) {
    ASSERT_EQ(errors_only.error[k], tile.error[k]) << k;
    ASSERT_EQ(errors_only.mass[k], tile.mass[k]) << k;
  }
}

TEST(WindowCorrelation, TilesWithoutValidPixelsSayNothing) {
  CorrelationTile tile = MakeTile(20, 20, 1.1, 1);
  Correlate({}, &tile);
  for (size_t k = 0; k < 20 * 20; ++k) {
    ASSERT_EQ(tile.error[k], 0);
    ASSERT_EQ(tile.mass[k], 0);
    ASSERT_EQ(tile.derivative[k], 0);
  }
}

}  // namespace
}  // namespace lsmvs
