#include "lsmvs/stereo/patch_match/matching_cost.h"

#include <algorithm>
#include <cmath>

namespace lsmvs {

namespace {

// Stands for the cost of a source that does not see a window; larger than any cost.
constexpr float kUnseen = 1e9f;
// Cost that a source without a view of the window has at least: about the smallest of several
// chance matches.
constexpr float kUnseenCost = 0.6f;

// So many sources are averaged: the others may be occluded.
constexpr int kNumBest = 2;
// A source that matches worse than the best one by more than this is taken for occluded, or for one
// that sees another side of an edge of depth.
constexpr float kMaxOverBest = 0.2f;

// Mean of the `num_best` smallest costs, in ascending order, cut at kMaxOverBest over the first: a
// right hypothesis beside an edge of depth, where some sources cannot see the window, is not beaten
// by one that all sources match badly. A source that sees nothing is taken to match as well as the
// others do, but no better than kUnseenCost: a hypothesis that few sources can judge is not beaten
// by chance where more can, nor does it win by leaving images.
void MeanOverSeen(const float (*best)[kPacketSize], int num_best, float* cost) {
  alignas(64) float sum[kPacketSize] = {}, num_seen[kPacketSize] = {};
  for (int k = 0; k < num_best; ++k) {
    for (int i = 0; i < kPacketSize; ++i) {
      const bool seen = best[k][i] < kUnseen;
      sum[i] += seen ? std::min(best[k][i], best[0][i] + kMaxOverBest) : 0.0f;
      num_seen[i] += seen ? 1.0f : 0.0f;
    }
  }
  const float count = static_cast<float>(num_best);
  for (int i = 0; i < kPacketSize; ++i) {
    const float mean = num_seen[i] > 0 ? sum[i] / num_seen[i] : kMaxPhotometricCost;
    const float unseen = std::max(mean, kUnseenCost);
    cost[i] = (sum[i] + (count - num_seen[i]) * unseen) / count;
  }
}

}  // namespace

MatchingCost::MatchingCost(const MatchingProblem& problem, const PacketPixels& pixels)
    : problem_(problem) {
  BuildPatch(*problem.gray, problem.weights, pixels, &patch_);
}

void MatchingCost::Zncc(const PlanePacket& planes, int source, float* zncc) const {
  ScorePacket(patch_, problem_.weights.window, planes,
              problem_.sources[static_cast<size_t>(source)], problem_.noise_variance, zncc);
}

void MatchingCost::GeometricError(const PlanePacket& planes, int source, float* error_px) const {
  ForwardBackwardError(patch_, planes, problem_.source_planes[static_cast<size_t>(source)],
                       problem_.geometric_max_px, error_px);
}

void MatchingCost::Cost(const PlanePacket& planes, std::span<const uint8_t> views,
                        float* cost) const {
  const int num_best = std::min(static_cast<int>(views.size()), kNumBest);
  alignas(64) float best[kNumBest][kPacketSize];
  alignas(64) float value[kPacketSize], error[kPacketSize];
  for (int k = 0; k < num_best; ++k) std::fill_n(best[k], kPacketSize, kUnseen);
  for (const uint8_t source : views) {
    Zncc(planes, source, value);
    for (float& x : value)
      x = x == kInvalidZncc ? kUnseen : std::min(kMaxPhotometricCost, 1.0f - x);
    if (!problem_.source_planes.empty()) {
      GeometricError(planes, source, error);
      for (int i = 0; i < kPacketSize; ++i) {
        value[i] += problem_.geometric_weight * error[i];
      }
    }
    for (int k = 0; k < num_best; ++k) {
      for (int i = 0; i < kPacketSize; ++i) {
        const float smaller = std::min(best[k][i], value[i]);
        value[i] = std::max(best[k][i], value[i]);
        best[k][i] = smaller;
      }
    }
  }
  MeanOverSeen(best, num_best, cost);
}

}  // namespace lsmvs
