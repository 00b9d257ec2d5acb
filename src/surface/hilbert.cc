#include "lsmvs/surface/hilbert.h"

#include <Eigen/Geometry>
#include <array>
#include <numeric>

namespace lsmvs {

namespace {

constexpr int kBits = 21;

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

}  // namespace

std::vector<uint32_t> HilbertOrder(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& x : points) box.extend(x);
  const float size = points.empty() ? 0.0f : box.sizes().maxCoeff();
  const double scale = size > 0 ? ((1 << kBits) - 1) / static_cast<double>(size) : 0.0;
  std::vector<KeyedIndex> items(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    std::array<uint32_t, 3> x;
    for (int k = 0; k < 3; ++k) {
      x[k] = static_cast<uint32_t>(scale * (static_cast<double>(points[i][k]) - box.min()[k]));
    }
    ToTransposedIndex(&x);
    items[i] = {Interleave(x), static_cast<uint32_t>(i)};
  }
  RadixSort(&items);
  std::vector<uint32_t> order(points.size());
  for (size_t i = 0; i < items.size(); ++i) order[i] = items[i].index;
  return order;
}

}  // namespace lsmvs
