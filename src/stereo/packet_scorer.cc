#include "lsmvs/stereo/packet_scorer.h"

#include <algorithm>
#include <cmath>

namespace lsmvs {

PacketScorer::PacketScorer(const MatchingProblem& problem, const PacketPixels& pixels)
    : problem_(problem) {
  BuildPatch(*problem.gray, problem.weights, pixels, &patch_);
}

void PacketScorer::Zncc(const PlanePacket& planes, int source, float* zncc) const {
  ScorePacket(patch_, problem_.weights.window, planes,
              problem_.sources[static_cast<size_t>(source)], problem_.noise_variance, zncc);
}

void PacketScorer::GeometricError(const PlanePacket& planes, int source, float* error_px) const {
  ForwardBackwardError(patch_, planes, problem_.source_planes[static_cast<size_t>(source)],
                       problem_.geometric_max_px, error_px);
}

void PacketScorer::Cost(const PlanePacket& planes, std::span<const uint8_t> views, int num_best,
                        float* cost) const {
  alignas(64) float best[kMaxSources][kPacketSize];
  alignas(64) float value[kPacketSize], error[kPacketSize];
  for (int k = 0; k < num_best; ++k) std::fill_n(best[k], kPacketSize, 1e9f);
  for (const uint8_t source : views) {
    Zncc(planes, source, value);
    for (float& x : value) x = std::min(kMaxPhotometricCost, 1.0f - x);
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
  for (int i = 0; i < kPacketSize; ++i) {
    float sum = 0;
    for (int k = 0; k < num_best; ++k) sum += best[k][i];
    cost[i] = sum / static_cast<float>(num_best);
  }
}

}  // namespace lsmvs
