#include "lsmvs/stereo/patch_match/matching_cost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

constexpr int kWidth = 80, kHeight = 60, kNumSources = 4;

// Sources that see the reference shifted by `q` pixels along a row each, all but the occluded ones,
// which see something else.
struct ShiftedSources {
  explicit ShiftedSources(int num_occluded) {
    const auto texture = [](uint64_t seed) {
      GrayImage image(kWidth, kHeight);
      Random random(seed);
      for (float& value : image.pixels) value = static_cast<float>(random.Below(256));
      return image;
    };
    reference = texture(1);
    problem.gray = &reference;
    problem.weights = PatchWeights({.half = 2, .step = 1}, 2.0, 51.0);
    for (int s = 0; s < kNumSources; ++s) {
      const bool occluded = s < num_occluded;
      cells.emplace_back(occluded ? texture(static_cast<uint64_t>(s) + 2) : reference);
      views.push_back(static_cast<uint8_t>(s));
    }
    for (int s = 0; s < kNumSources; ++s) {
      SourceView source;
      source.image = &cells[static_cast<size_t>(s)];
      const float identity[9] = {1, 0, -0.5f, 0, 1, -0.5f, 0, 0, 1};
      std::copy(identity, identity + 9, source.m);
      source.e[0] = s % 2 == 0 ? 1.0f : -1.0f;
      problem.sources.push_back(source);
    }
    for (int lane = 0; lane < kPacketSize; ++lane) {
      pixels[static_cast<size_t>(lane)] = {20 + 2 * lane, 30};
    }
  }

  // Inverse depth 1 is the reference's own place in every source.
  std::vector<float> CostsAt(float shift) const {
    MatchingProblem shifted = problem;
    PlanePacket planes;
    for (SourceView& source : shifted.sources) source.m[2] -= source.e[0];
    for (int lane = 0; lane < kPacketSize; ++lane) {
      planes.q[lane] = 1 + shift;
      planes.qx[lane] = planes.qy[lane] = 0;
    }
    alignas(64) float costs[kPacketSize];
    MatchingCost(shifted, pixels).Cost(planes, views, costs);
    return {costs, costs + kPacketSize};
  }

  GrayImage reference;
  std::vector<PackedImage> cells;
  std::vector<uint8_t> views;
  MatchingProblem problem;
  PacketPixels pixels;
};

float Mean(const std::vector<float>& values) {
  float sum = 0;
  for (const float value : values) sum += value;
  return sum / static_cast<float>(values.size());
}

TEST(MatchingCost, RightPlaneCostsNothingWhereTwoSourcesSeeIt) {
  for (const int num_occluded : {0, 1, 2}) {
    for (const float cost : ShiftedSources(num_occluded).CostsAt(0)) EXPECT_LT(cost, 0.01f);
  }
}

// One source that sees the surface is enough to tell the right plane from wrong ones.
TEST(MatchingCost, RightPlaneWinsWhereOneSourceSeesIt) {
  const ShiftedSources sources(kNumSources - 1);
  const std::vector<float> right = sources.CostsAt(0);
  for (const float cost : right) EXPECT_LT(cost, 0.11f);
  for (const float shift : {-7.0f, -3.0f, 3.0f, 7.0f}) {
    const std::vector<float> wrong = sources.CostsAt(shift);
    for (size_t lane = 0; lane < kPacketSize; ++lane) EXPECT_LT(right[lane], wrong[lane]);
    EXPECT_GT(Mean(wrong), 0.5f);
  }
}

// By the definition, from the ZNCC of each source.
TEST(MatchingCost, CostIsTheCutMeanOfTheBest) {
  const ShiftedSources sources(2);
  for (const float shift : {0.0f, 0.3f, 0.7f, 2.0f}) {
    const std::vector<float> costs = sources.CostsAt(shift);
    MatchingProblem shifted = sources.problem;
    for (SourceView& source : shifted.sources) source.m[2] -= source.e[0];
    const MatchingCost scorer(shifted, sources.pixels);
    PlanePacket planes;
    std::fill_n(planes.q, kPacketSize, 1 + shift);
    std::fill_n(planes.qx, kPacketSize, 0.0f);
    std::fill_n(planes.qy, kPacketSize, 0.0f);
    std::vector<std::vector<float>> of_lane(kPacketSize);
    for (int s = 0; s < kNumSources; ++s) {
      alignas(64) float zncc[kPacketSize];
      scorer.Zncc(planes, s, zncc);
      for (size_t lane = 0; lane < kPacketSize; ++lane) {
        of_lane[lane].push_back(std::min(kMaxPhotometricCost, 1 - zncc[lane]));
      }
    }
    for (size_t lane = 0; lane < kPacketSize; ++lane) {
      std::vector<float>& values = of_lane[lane];
      std::sort(values.begin(), values.end());
      EXPECT_NEAR(costs[lane], 0.5f * (values[0] + std::min(values[1], values[0] + 0.2f)), 1e-5f);
    }
  }
}

}  // namespace
}  // namespace lsmvs
