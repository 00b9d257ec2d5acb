#include "lsmvs/stereo/quasi_dense/window.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/util/check.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/stereo/quasi_dense/window.cc"
#include <hwy/foreach_target.h>
// clang-format off
#include <hwy/highway.h>
// clang-format on
#include "lsmvs/stereo/sampling/packed_sampler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lsmvs::quasi_dense::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Sixteen lanes on every instruction set, in one vector or several, so that sums are taken in the
// same order everywhere. Products and sums are never fused for the same reason.
constexpr size_t kNumLanes = 16;
using FloatTag = hn::CappedTag<float, kNumLanes>;
using Floats = hn::Vec<FloatTag>;
constexpr size_t kLanesOfVector = hn::MaxLanes(FloatTag());
constexpr size_t kNumVectors = kNumLanes / kLanesOfVector;

struct Sums {
  Floats of_vector[kNumVectors];

  HWY_INLINE Sums() {
    for (Floats& sum : of_vector) sum = hn::Zero(FloatTag());
  }
  HWY_INLINE float Total() const {
    alignas(64) float lane[kNumLanes];
    for (size_t v = 0; v < kNumVectors; ++v) {
      hn::Store(of_vector[v], FloatTag(), lane + v * kLanesOfVector);
    }
    for (size_t half = kNumLanes / 2; half > 0; half /= 2) {
      for (size_t k = 0; k < half; ++k) lane[k] += lane[k + half];
    }
    return lane[0];
  }
};

// Bilinear samples of the warped pattern, from sample `first` on.
struct Sampler {
  HWY_INLINE Sampler(const PackedImage& image, const WindowPattern& window_pattern,
                     const WindowWarp& warp)
      : cells(image),
        pattern(window_pattern),
        x(hn::Set(FloatTag(), warp.x - 1.0f)),
        y(hn::Set(FloatTag(), warp.y - 1.0f)),
        xx(hn::Set(FloatTag(), warp.xx)),
        xy(hn::Set(FloatTag(), warp.xy)),
        yx(hn::Set(FloatTag(), warp.yx)),
        yy(hn::Set(FloatTag(), warp.yy)) {}

  HWY_INLINE Floats Sample(size_t first) const {
    const FloatTag f;
    const Floats dx = hn::Load(f, pattern.dx + first), dy = hn::Load(f, pattern.dy + first);
    return cells(hn::Add(x, hn::Add(hn::Mul(xx, dx), hn::Mul(xy, dy))),
                 hn::Add(y, hn::Add(hn::Mul(yx, dx), hn::Mul(yy, dy))));
  }

  lsmvs::HWY_NAMESPACE::PackedSampler<FloatTag, lsmvs::HWY_NAMESPACE::PortableLerp> cells;
  const WindowPattern& pattern;
  Floats x, y, xx, xy, yx, yy;
};

void ReadReferenceWindow(const PackedImage& image, const WindowPattern& pattern,
                         const WindowWarp& warp, ReferenceWindow* window) {
  const FloatTag f;
  const Sampler sampler(image, pattern, warp);
  const size_t num_samples = static_cast<size_t>(pattern.num_samples);
  Sums weighted;
  for (size_t s = 0; s < num_samples; s += kNumLanes) {
    for (size_t v = 0, k = s; v < kNumVectors; ++v, k += kLanesOfVector) {
      const Floats value = sampler.Sample(k);
      hn::Store(value, f, window->value + k);
      weighted.of_vector[v] =
          hn::Add(weighted.of_vector[v], hn::Mul(value, hn::Load(f, pattern.weight + k)));
    }
  }
  window->mean = weighted.Total();
  const Floats mean = hn::Set(f, window->mean);
  Sums squared;
  for (size_t s = 0; s < num_samples; s += kNumLanes) {
    for (size_t v = 0, k = s; v < kNumVectors; ++v, k += kLanesOfVector) {
      const Floats value = hn::Sub(hn::Load(f, window->value + k), mean);
      const Floats product = hn::Mul(value, hn::Load(f, pattern.weight + k));
      hn::Store(product, f, window->value + k);
      squared.of_vector[v] = hn::Add(squared.of_vector[v], hn::Mul(product, value));
    }
  }
  window->deviation = std::sqrt(squared.Total());
  const Floats scale = hn::Set(f, window->deviation > 1e-3f ? 1.0f / window->deviation : 0.0f);
  for (size_t k = 0; k < num_samples; k += kLanesOfVector) {
    hn::Store(hn::Mul(hn::Load(f, window->value + k), scale), f, window->value + k);
  }
}

float CompareWindow(const PackedImage& image, const WindowPattern& pattern, const WindowWarp& warp,
                    const ReferenceWindow& reference) {
  const FloatTag f;
  const Sampler sampler(image, pattern, warp);
  const Floats shift = hn::Set(f, reference.mean);
  Sums first, second, cross;
  for (size_t s = 0; s < static_cast<size_t>(pattern.num_samples); s += kNumLanes) {
    for (size_t v = 0, k = s; v < kNumVectors; ++v, k += kLanesOfVector) {
      const Floats value = hn::Sub(sampler.Sample(k), shift);
      const Floats weighted = hn::Mul(value, hn::Load(f, pattern.weight + k));
      first.of_vector[v] = hn::Add(first.of_vector[v], weighted);
      second.of_vector[v] = hn::Add(second.of_vector[v], hn::Mul(weighted, value));
      cross.of_vector[v] =
          hn::Add(cross.of_vector[v], hn::Mul(value, hn::Load(f, reference.value + k)));
    }
  }
  const float mean = first.Total();
  const float variance = second.Total() - mean * mean;
  if (!(variance > 1e-2f)) return 0.0f;
  return std::clamp(cross.Total() / std::sqrt(variance), -1.0f, 1.0f);
}

}  // namespace lsmvs::quasi_dense::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lsmvs::quasi_dense {

HWY_EXPORT(ReadReferenceWindow);
HWY_EXPORT(CompareWindow);

WindowPattern MakeWindowPattern(int radius) {
  LSMVS_CHECK_GE(radius, 1);
  LSMVS_CHECK_LE(radius, kMaxWindowRadius);
  WindowPattern pattern;
  pattern.radius = radius;
  float total = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      if (std::abs(dx) == radius && std::abs(dy) == radius) continue;
      const int k = pattern.num_samples++;
      pattern.dx[k] = static_cast<float>(dx);
      pattern.dy[k] = static_cast<float>(dy);
      pattern.weight[k] = std::exp(-0.5f * static_cast<float>(dx * dx + dy * dy) /
                                   static_cast<float>(radius * radius));
      total += pattern.weight[k];
    }
  }
  for (int k = 0; k < pattern.num_samples; ++k) pattern.weight[k] /= total;
  pattern.num_samples = (pattern.num_samples + 15) / 16 * 16;
  return pattern;
}

bool WindowInside(const PackedImage& image, const WindowPattern& pattern, const WindowWarp& warp) {
  const float radius = static_cast<float>(pattern.radius);
  const float reach_x = radius * (std::abs(warp.xx) + std::abs(warp.xy)) + 0.51f;
  const float reach_y = radius * (std::abs(warp.yx) + std::abs(warp.yy)) + 0.51f;
  // Written so that NaN is outside.
  return warp.x >= reach_x && warp.y >= reach_y &&
         warp.x <= static_cast<float>(image.width) - reach_x &&
         warp.y <= static_cast<float>(image.height) - reach_y;
}

void ReadReferenceWindow(const PackedImage& image, const WindowPattern& pattern,
                         const WindowWarp& warp, ReferenceWindow* window) {
  HWY_DYNAMIC_DISPATCH(ReadReferenceWindow)(image, pattern, warp, window);
}

float CompareWindow(const PackedImage& image, const WindowPattern& pattern, const WindowWarp& warp,
                    const ReferenceWindow& reference) {
  return HWY_DYNAMIC_DISPATCH(CompareWindow)(image, pattern, warp, reference);
}

}  // namespace lsmvs::quasi_dense
#endif
