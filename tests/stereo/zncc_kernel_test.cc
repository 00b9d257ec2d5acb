#include "lsmvs/stereo/sampling/zncc_kernel.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <random>

#include "lsmvs/image/sampling.h"
#include "lsmvs/stereo/patch_match/matching_cost.h"

namespace lsmvs {
namespace {

// Even grey values: half of them are whole, too, as PackedImage holds them.
GrayImage WavyImage(int width, int height, double shift) {
  GrayImage image(width, height);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double x = column + 0.3 * row + shift, y = row - 0.2 * column;
      const double gray =
          128 + 50 * std::sin(0.31 * x) * std::cos(0.23 * y) + 30 * std::sin(0.11 * y + 0.07 * x);
      image(column, row) = static_cast<float>(2 * std::round(gray / 2));
    }
  }
  return image;
}

// A packet, planes and views that look at each other from a little aside.
struct PacketScene {
  explicit PacketScene(unsigned seed)
      : reference(WavyImage(90, 70, 0)), source_image(WavyImage(90, 70, 2)) {
    cells = PackedImage(source_image);
    problem.gray = &reference;
    problem.weights = PatchWeights({}, 5.0, 51.0);
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
    };
    source.image = &cells;
    const float m[9] = {1.01f, 0.02f, -2.0f, -0.03f, 0.98f, 1.5f, 2e-4f, -1e-4f, 1.0f};
    std::copy(m, m + 9, source.m);
    source.e[0] = 40.0f, source.e[1] = -6.0f, source.e[2] = 0.1f;
    for (int lane = 0; lane < kPacketSize; ++lane) {
      pixels[static_cast<size_t>(lane)] = {static_cast<int>(uniform(0, 90)),
                                           static_cast<int>(uniform(0, 70))};
      planes.q[lane] = uniform(0.05, 0.3);
      planes.qx[lane] = uniform(-0.005, 0.005);
      planes.qy[lane] = uniform(-0.005, 0.005);
    }
    BuildPatch(reference, problem.weights, pixels, &patch);
  }

  GrayImage reference, source_image;
  PackedImage cells;
  MatchingProblem problem;
  SourceView source;
  PacketPixels pixels;
  PatchPacket patch;
  PlanePacket planes;
};

struct Moments {
  double weight = 0, r = 0, s = 0, rr = 0, ss = 0, rs = 0;
  void Add(double w, double x, double y) {
    weight += w, r += w * x, s += w * y, rr += w * x * x, ss += w * y * y, rs += w * x * y;
  }
  double Zncc(double noise) const {
    const double mr = r / weight, ms = s / weight;
    const double vr = rr / weight - mr * mr, vs = ss / weight - ms * ms;
    return (rs / weight - mr * ms) / std::sqrt((vr + noise) * (vs + noise));
  }
};

// The definition, in double: NaN where a sample would leave the image.
double ObviousZncc(const PacketScene& scene, int lane, double noise) {
  const auto [column, row] = scene.pixels[static_cast<size_t>(lane)];
  const WindowShape& window = scene.problem.weights.window;
  const double center = scene.reference(column, row);
  Moments moments;
  for (int i = -window.half; i <= window.half; ++i) {
    for (int j = -window.half; j <= window.half; ++j) {
      const double dx = j * window.step, dy = i * window.step;
      const double u = column + 0.5 + dx, v = row + 0.5 + dy;
      const double q =
          double(scene.planes.q[lane]) + dx * scene.planes.qx[lane] + dy * scene.planes.qy[lane];
      const float *m = scene.source.m, *e = scene.source.e;
      const double w = m[6] * u + m[7] * v + m[8] + e[2] * q;
      const double x = (m[0] * u + m[1] * v + m[2] + e[0] * q) / w;
      const double y = (m[3] * u + m[4] * v + m[5] + e[1] * q) / w;
      if (!InsideForSampling(scene.source_image, x + 0.5, y + 0.5)) return NAN;
      const int c = column + static_cast<int>(dx), r = row + static_cast<int>(dy);
      if (!scene.reference.Inside(c, r)) continue;
      const double value = scene.reference(c, r);
      const double color = std::round(std::abs(value - center) * kColorSteps) / kColorSteps / 51.0;
      const double weight = std::exp(-(dx * dx + dy * dy) / 50.0 - 0.5 * color * color);
      moments.Add(weight, value, SampleBilinear(scene.source_image, x + 0.5, y + 0.5).value);
    }
  }
  return moments.Zncc(noise);
}

void ExpectKernelMatchesDefinition() {
  int num_compared = 0, num_outside = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const PacketScene scene(seed);
    alignas(64) float zncc[kPacketSize];
    ScorePacket(scene.patch, scene.problem.weights.window, scene.planes, scene.source, 4.0f, zncc);
    for (int lane = 0; lane < kPacketSize; ++lane) {
      const double expected = ObviousZncc(scene, lane, 4.0);
      if (std::isnan(expected)) {
        EXPECT_EQ(zncc[lane], kInvalidZncc) << seed << " " << lane;
        ++num_outside;
      } else if (zncc[lane] != kInvalidZncc) {  // may refuse windows that are stretched much
        EXPECT_NEAR(zncc[lane], expected, 2e-3) << seed << " " << lane;
        ++num_compared;
      }
    }
  }
  EXPECT_GT(num_compared, 500);
  EXPECT_GT(num_outside, 50);
}

TEST(ScorePacket, MatchesDefinitionOnEveryInstructionSet) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    SCOPED_TRACE(ScorePacketTarget());
    ExpectKernelMatchesDefinition();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(ScorePacket, IsNearOneOnItself) {
  PacketScene scene(1);
  scene.cells = PackedImage(scene.reference);
  const float identity[9] = {1, 0, -0.5f, 0, 1, -0.5f, 0, 0, 1};
  std::copy(identity, identity + 9, scene.source.m);
  std::fill(scene.source.e, scene.source.e + 3, 0.0f);
  for (PixelPosition& pixel : scene.pixels) pixel = {40, 30};
  BuildPatch(scene.reference, scene.problem.weights, scene.pixels, &scene.patch);
  alignas(64) float zncc[kPacketSize];
  ScorePacket(scene.patch, scene.problem.weights.window, scene.planes, scene.source, 4.0f, zncc);
  const float variance = scene.patch.variance[0];
  for (const float value : zncc) EXPECT_NEAR(value, variance / (variance + 4.0f), 1e-3f);
}

TEST(ScorePacket, DoesNotFeelGainAndOffset) {
  PacketScene scene(2);
  alignas(64) float before[kPacketSize], after[kPacketSize];
  ScorePacket(scene.patch, scene.problem.weights.window, scene.planes, scene.source, 0.01f, before);
  for (float& value : scene.source_image.pixels) value = 0.5f * value + 20;
  scene.cells = PackedImage(scene.source_image);
  ScorePacket(scene.patch, scene.problem.weights.window, scene.planes, scene.source, 0.01f, after);
  for (int lane = 0; lane < kPacketSize; ++lane) EXPECT_NEAR(before[lane], after[lane], 2e-3f);
}

TEST(ScorePacket, RefusesPlanesBehindAndWindowsOutside) {
  PacketScene scene(3);
  for (float& q : scene.planes.q) q = -0.1f;
  scene.planes.q[1] = 100.0f;  // far outside
  scene.planes.q[2] = NAN;
  alignas(64) float zncc[kPacketSize];
  ScorePacket(scene.patch, scene.problem.weights.window, scene.planes, scene.source, 4.0f, zncc);
  for (const float value : zncc) EXPECT_EQ(value, kInvalidZncc);
}

// Lanes of little variance must be as if the window had twice the step (and the Gaussian twice the
// width), the others as if nothing were stretched.
TEST(ScorePacket, StretchesWindowsOfLittleVarianceOnly) {
  const PatchWeights narrow({.half = 2, .step = 1}, 2.0, 51.0);
  const PatchWeights wide({.half = 2, .step = 2}, 4.0, 51.0);
  PatchWeights adaptive = narrow;
  adaptive.min_variance = 150;
  int num_narrow = 0, num_wide = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const PacketScene scene(seed);
    PatchPacket by_narrow, by_wide, by_adaptive;
    BuildPatch(scene.reference, narrow, scene.pixels, &by_narrow);
    BuildPatch(scene.reference, wide, scene.pixels, &by_wide);
    BuildPatch(scene.reference, adaptive, scene.pixels, &by_adaptive);
    alignas(64) float from_narrow[kPacketSize], from_wide[kPacketSize], zncc[kPacketSize];
    ScorePacket(by_narrow, narrow.window, scene.planes, scene.source, 4.0f, from_narrow);
    ScorePacket(by_wide, wide.window, scene.planes, scene.source, 4.0f, from_wide);
    ScorePacket(by_adaptive, adaptive.window, scene.planes, scene.source, 4.0f, zncc);
    for (int lane = 0; lane < kPacketSize; ++lane) {
      const bool stretched = by_narrow.variance[lane] < adaptive.min_variance;
      const PatchPacket& patch = stretched ? by_wide : by_narrow;
      EXPECT_NEAR(by_adaptive.variance[lane], patch.variance[lane], 1e-3 * patch.variance[lane]);
      EXPECT_NEAR(zncc[lane], (stretched ? from_wide : from_narrow)[lane], 1e-4);
      (stretched ? num_wide : num_narrow) += zncc[lane] != kInvalidZncc;
    }
  }
  EXPECT_GT(num_narrow, 30);
  EXPECT_GT(num_wide, 30);
}

TEST(BuildPatch, WeightsSumToOneAndGraysAreCentered) {
  const PacketScene scene(4);
  for (int lane = 0; lane < kPacketSize; ++lane) {
    double weights = 0, centered = 0;
    for (int sample = 0; sample < scene.problem.weights.window.NumSamples(); ++sample) {
      weights += scene.patch.weight[sample][lane];
      centered += scene.patch.weighted_gray[sample][lane];
    }
    EXPECT_NEAR(weights, 1.0, 1e-5);
    EXPECT_NEAR(centered, 0.0, 1e-3);
  }
}

}  // namespace
}  // namespace lsmvs
