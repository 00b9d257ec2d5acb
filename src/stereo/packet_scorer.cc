#include "lsmvs/stereo/packet_scorer.h"

#include <algorithm>
#include <cmath>

namespace lsmvs {

std::vector<float> SpatialWeights(const WindowShape& window, double sigma_px) {
  std::vector<float> weights;
  for (int row = -window.half; row <= window.half; ++row) {
    for (int column = -window.half; column <= window.half; ++column) {
      const double squared = (row * row + column * column) * double(window.step) * window.step;
      weights.push_back(static_cast<float>(std::exp(-squared / (2 * sigma_px * sigma_px))));
    }
  }
  return weights;
}

std::vector<float> ColorWeights(double sigma_gray) {
  std::vector<float> weights;
  for (int i = 0; i <= 256 * kColorSteps; ++i) {
    const double difference = static_cast<double>(i) / kColorSteps / sigma_gray;
    weights.push_back(static_cast<float>(std::exp(-0.5 * difference * difference)));
  }
  return weights;
}

void BuildPatch(const MatchingProblem& problem, const PacketPixels& pixels, PatchPacket* patch) {
  const GrayImage& gray = *problem.gray;
  const WindowShape& window = problem.window;
  const int num_samples = window.NumSamples();
  const float* color_weights = problem.color_weights.data();
  for (int lane = 0; lane < kPacketSize; ++lane) {
    const auto [column, row] = pixels[static_cast<size_t>(lane)];
    patch->u[lane] = static_cast<float>(column) + 0.5f;
    patch->v[lane] = static_cast<float>(row) + 0.5f;
    const float center = gray(column, row);
    float sum_weights = 0, sum = 0;
    int sample = 0;
    for (int y = -window.half; y <= window.half; ++y) {
      for (int x = -window.half; x <= window.half; ++x, ++sample) {
        const int sample_column = column + x * window.step, sample_row = row + y * window.step;
        const bool inside = gray.Inside(sample_column, sample_row);
        const float value = inside ? gray(sample_column, sample_row) : center;
        const int difference = static_cast<int>(std::abs(value - center) * kColorSteps + 0.5f);
        const float weight = inside ? problem.spatial_weights[static_cast<size_t>(sample)] *
                                          color_weights[std::min(difference, 256 * kColorSteps)]
                                    : 0.0f;
        patch->weight[sample][lane] = weight;
        patch->weighted_gray[sample][lane] = value;
        sum_weights += weight;
        sum += weight * value;
      }
    }
    const float mean = sum / sum_weights, scale = 1.0f / sum_weights;
    float variance = 0;
    for (sample = 0; sample < num_samples; ++sample) {
      const float weight = patch->weight[sample][lane] * scale;
      const float centered = patch->weighted_gray[sample][lane] - mean;
      patch->weight[sample][lane] = weight;
      patch->weighted_gray[sample][lane] = weight * centered;
      variance += weight * centered * centered;
    }
    patch->variance[lane] = variance;
  }
}

PacketScorer::PacketScorer(const MatchingProblem& problem, const PacketPixels& pixels)
    : problem_(problem) {
  BuildPatch(problem, pixels, &patch_);
}

void PacketScorer::Zncc(const PlanePacket& planes, int source, float* zncc) const {
  ScorePacket(patch_, problem_.window, planes, problem_.sources[static_cast<size_t>(source)],
              problem_.noise_variance, zncc);
}

void PacketScorer::GeometricError(const PlanePacket& planes, int source, float* error_px) const {
  const SourcePlanes& view = problem_.source_planes[static_cast<size_t>(source)];
  const float cut = problem_.geometric_max_px;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    error_px[lane] = cut;
    if (view.planes == nullptr) continue;
    const float u = patch_.u[lane], v = patch_.v[lane], q = planes.q[lane];
    const auto project = [](const float* m, const float* e, float a, float b, float inverse_depth,
                            float* x, float* y) {
      const float w = m[6] * a + m[7] * b + m[8] + e[2] * inverse_depth;
      const float inverse = 1.0f / w;
      *x = (m[0] * a + m[1] * b + m[2] + e[0] * inverse_depth) * inverse;
      *y = (m[3] * a + m[4] * b + m[5] + e[1] * inverse_depth) * inverse;
      return w;
    };
    float x, y, back_u, back_v;
    if (!(project(view.forward_m, view.forward_e, u, v, q, &x, &y) > 0)) continue;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(view.planes->width) &&
          y < static_cast<float>(view.planes->height))) {
      continue;
    }
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const Plane& plane = (*view.planes)(column, row);
    if (!(plane.q > 0)) continue;
    const float there = plane.q + plane.qx * (x - static_cast<float>(column) - 0.5f) +
                        plane.qy * (y - static_cast<float>(row) - 0.5f);
    if (!(project(view.backward_m, view.backward_e, x, y, there, &back_u, &back_v) > 0)) continue;
    const float du = back_u - u, dv = back_v - v;
    error_px[lane] = std::min(cut, std::sqrt(du * du + dv * dv));
  }
}

void PacketScorer::Cost(const PlanePacket& planes, std::span<const uint8_t> views, int num_best,
                        float* cost) const {
  alignas(64) float best[kMaxSources][kPacketSize];
  alignas(64) float value[kPacketSize], error[kPacketSize];
  for (int k = 0; k < num_best; ++k) std::fill_n(best[k], kPacketSize, kMaxCost);
  for (const uint8_t source : views) {
    Zncc(planes, source, value);
    for (float& x : value) x = x == kInvalidZncc ? kMaxCost : 1.0f - x;
    if (!problem_.source_planes.empty()) {
      GeometricError(planes, source, error);
      for (int i = 0; i < kPacketSize; ++i) {
        value[i] = std::min(kMaxCost, value[i] + problem_.geometric_weight * error[i]);
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
