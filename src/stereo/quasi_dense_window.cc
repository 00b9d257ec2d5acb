#include "lsmvs/stereo/quasi_dense_window_internal.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lsmvs/util/check.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/stereo/quasi_dense_window.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lsmvs::quasi_dense::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Sixteen lanes on every instruction set, in one vector or several, so that sums are taken in the
// same order everywhere. Products and sums are never fused for the same reason.
constexpr size_t kNumLanes = 16;
using FloatTag = hn::CappedTag<float, kNumLanes>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
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

// 1.5 * 2^23: a float of this size counts in ones.
constexpr float kRound = 12582912.0f;

// Bits of kRound as row times the width plus as column, modulo 2^32 as the vectors compute it.
HWY_INLINE int32_t OriginBits(int width) {
  const uint32_t bits = std::bit_cast<uint32_t>(kRound);
  return static_cast<int32_t>(bits * static_cast<uint32_t>(width) + bits);
}

// Bilinear samples of the warped pattern, from sample `first` on.
struct Sampler {
  HWY_INLINE Sampler(const CellImage& image, const WindowPattern& window_pattern,
                     const WindowWarp& warp)
      : cells(reinterpret_cast<const int32_t*>(image.pixels.data())),
        pattern(window_pattern),
        width(hn::Set(IntTag(), image.width)),
        origin(hn::Set(IntTag(), OriginBits(image.width))),
        x(hn::Set(FloatTag(), warp.x - 0.5f)),
        y(hn::Set(FloatTag(), warp.y - 0.5f)),
        xx(hn::Set(FloatTag(), warp.xx)),
        xy(hn::Set(FloatTag(), warp.xy)),
        yx(hn::Set(FloatTag(), warp.yx)),
        yy(hn::Set(FloatTag(), warp.yy)) {}

  HWY_INLINE Floats Sample(size_t first) const {
    const FloatTag f;
    const IntTag i;
    const Floats dx = hn::Load(f, pattern.dx + first), dy = hn::Load(f, pattern.dy + first);
    const Floats px = hn::Add(x, hn::Add(hn::Mul(xx, dx), hn::Mul(xy, dy)));
    const Floats py = hn::Add(y, hn::Add(hn::Mul(yx, dx), hn::Mul(yy, dy)));
    // Adding kRound leaves the nearest whole number in the low bits: of half a pixel less, the
    // corner of the cell. The bits of both sums carry those of kRound, which `origin` takes away.
    const Floats round = hn::Set(f, kRound), half = hn::Set(f, 0.5f);
    const Floats column = hn::Add(hn::Sub(px, half), round);
    const Floats row = hn::Add(hn::Sub(py, half), round);
    const Floats a = hn::Sub(px, hn::Sub(column, round));
    const Floats b = hn::Sub(py, hn::Sub(row, round));
    const Ints index =
        hn::Sub(hn::Add(hn::Mul(hn::BitCast(i, row), width), hn::BitCast(i, column)), origin);
    const Ints cell = hn::GatherIndex(i, cells, index);
    const Ints byte = hn::Set(i, 255);
    const Floats top_left = hn::ConvertTo(f, hn::And(cell, byte));
    const Floats top_right = hn::ConvertTo(f, hn::And(hn::ShiftRight<8>(cell), byte));
    const Floats bottom_left = hn::ConvertTo(f, hn::And(hn::ShiftRight<16>(cell), byte));
    const Floats bottom_right = hn::ConvertTo(f, hn::And(hn::ShiftRight<24>(cell), byte));
    const Floats top = hn::Add(top_left, hn::Mul(a, hn::Sub(top_right, top_left)));
    const Floats bottom = hn::Add(bottom_left, hn::Mul(a, hn::Sub(bottom_right, bottom_left)));
    return hn::Add(top, hn::Mul(b, hn::Sub(bottom, top)));
  }

  const int32_t* cells;
  const WindowPattern& pattern;
  Ints width, origin;
  Floats x, y, xx, xy, yx, yy;
};

void ReadReferenceWindow(const CellImage& image, const WindowPattern& pattern,
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

float CompareWindow(const CellImage& image, const WindowPattern& pattern, const WindowWarp& warp,
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

CellImage PackCells(const GrayImage& image) {
  Raster<uint8_t> bytes(image.width, image.height);
  std::transform(image.pixels.begin(), image.pixels.end(), bytes.pixels.begin(), [](float value) {
    return static_cast<uint8_t>(std::clamp(value, 0.0f, 255.0f) + 0.5f);
  });
  CellImage cells(image.width, image.height);
  for (int row = 0; row < image.height; ++row) {
    const uint8_t* top = bytes.Row(row);
    const uint8_t* bottom = bytes.Row(std::min(row + 1, image.height - 1));
    for (int column = 0; column < image.width; ++column) {
      const int right = std::min(column + 1, image.width - 1);
      cells(column, row) =
          static_cast<uint32_t>(top[column]) | static_cast<uint32_t>(top[right]) << 8 |
          static_cast<uint32_t>(bottom[column]) << 16 | static_cast<uint32_t>(bottom[right]) << 24;
    }
  }
  return cells;
}

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

bool WindowInside(const CellImage& image, const WindowPattern& pattern, const WindowWarp& warp) {
  const float radius = static_cast<float>(pattern.radius);
  const float reach_x = radius * (std::abs(warp.xx) + std::abs(warp.xy)) + 0.51f;
  const float reach_y = radius * (std::abs(warp.yx) + std::abs(warp.yy)) + 0.51f;
  // Written so that NaN is outside.
  return warp.x >= reach_x && warp.y >= reach_y &&
         warp.x <= static_cast<float>(image.width) - reach_x &&
         warp.y <= static_cast<float>(image.height) - reach_y;
}

void ReadReferenceWindow(const CellImage& image, const WindowPattern& pattern,
                         const WindowWarp& warp, ReferenceWindow* window) {
  HWY_DYNAMIC_DISPATCH(ReadReferenceWindow)(image, pattern, warp, window);
}

float CompareWindow(const CellImage& image, const WindowPattern& pattern, const WindowWarp& warp,
                    const ReferenceWindow& reference) {
  return HWY_DYNAMIC_DISPATCH(CompareWindow)(image, pattern, warp, reference);
}

}  // namespace lsmvs::quasi_dense
#endif
