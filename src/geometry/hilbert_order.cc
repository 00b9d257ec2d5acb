#include "lsmvs/geometry/hilbert_order.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>

namespace lsmvs {

namespace {

constexpr int kBits = kHilbertBits;
constexpr double kLastStep = (1 << kBits) - 1;

// J. Skilling: Programming the Hilbert curve, 2004: coordinates to the transposed index, in place.
void ToTransposedIndex(std::array<uint32_t, 3>* x) {
  auto& [a, b, c] = *x;
  for (uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) {
    const uint32_t p = q - 1;
    for (uint32_t& value : *x) {
      if (value & q) {
        a ^= p;
      } else {
        const uint32_t t = (a ^ value) & p;
        a ^= t;
        value ^= t;
      }
    }
  }
  b ^= a;
  c ^= b;
  uint32_t t = 0;
  for (uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) {
    if (c & q) t ^= q - 1;
  }
  a ^= t;
  b ^= t;
  c ^= t;
}

uint64_t Interleave(const std::array<uint32_t, 3>& x) {
  uint64_t key = 0;
  for (int bit = kBits - 1; bit >= 0; --bit) {
    for (const uint32_t value : x) key = (key << 1) | ((value >> bit) & 1u);
  }
  return key;
}

struct KeyedIndex {
  uint64_t key;
  uint32_t index;
};

void RadixSort(std::vector<KeyedIndex>* items) {
  constexpr int kDigit = 11;
  std::vector<KeyedIndex> other(items->size());
  for (int shift = 0; shift < 3 * kBits; shift += kDigit) {
    std::array<uint32_t, (1 << kDigit) + 1> begin = {};
    const auto digit = [&](const KeyedIndex& item) {
      return (item.key >> shift) & ((1u << kDigit) - 1);
    };
    for (const KeyedIndex& item : *items) ++begin[digit(item) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (const KeyedIndex& item : *items) other[begin[digit(item)]++] = item;
    items->swap(other);
  }
}

template <class Scalar>
std::vector<uint32_t> OrderOf(std::span<const Eigen::Vector<Scalar, 3>> points) {
  Eigen::AlignedBox<Scalar, 3> box;
  for (const auto& x : points) box.extend(x);
  const Scalar size = points.empty() ? Scalar(0) : box.sizes().maxCoeff();
  const double scale = size > 0 ? kLastStep / static_cast<double>(size) : 0.0;
  std::vector<KeyedIndex> items(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    std::array<uint32_t, 3> x;
    for (int k = 0; k < 3; ++k) {
      const double step = scale * (static_cast<double>(points[i][k]) - box.min()[k]);
      x[k] = step > 0 ? static_cast<uint32_t>(std::min(step, kLastStep)) : 0;  // also if it is NaN
    }
    items[i] = {HilbertIndex(x), static_cast<uint32_t>(i)};
  }
  RadixSort(&items);
  std::vector<uint32_t> order(points.size());
  for (size_t i = 0; i < items.size(); ++i) order[i] = items[i].index;
  return order;
}

}  // namespace

uint64_t HilbertIndex(std::array<uint32_t, 3> step) {
  ToTransposedIndex(&step);
  return Interleave(step);
}

std::vector<uint32_t> HilbertOrder(std::span<const Eigen::Vector3f> points) {
  return OrderOf<float>(points);
}

std::vector<uint32_t> HilbertOrder(std::span<const Eigen::Vector3d> points) {
  return OrderOf<double>(points);
}

}  // namespace lsmvs
