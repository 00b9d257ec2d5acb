#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace lsmvs {

// Hashed cubic grid over points that are added one by one; finds those within a radius of up to the
// cell size.
class PointGrid {
 public:
  // Keeps a pointer to `points`, which may grow. Cell size 0 finds equal points only.
  PointGrid(float cell_size, const std::vector<Eigen::Vector3f>* points);

  // Adds points[index].
  void Insert(uint32_t index);
  // Adds all points, but none that lies within `distance` of an earlier one.
  void InsertThinned(float distance);
  // Calls visit(index) for all points within `radius` <= cell size of x, and for some farther ones.
  template <class Visit>
  void ForEachNear(const Eigen::Vector3f& x, float radius, const Visit& visit) const;

 private:
  static constexpr uint32_t kNone = 0xFFFFFFFFu;
  struct Entry {
    uint64_t key = 0;
    uint32_t first = kNone;
  };

  std::array<int32_t, 3> CellOf(const Eigen::Vector3f& x) const {
    std::array<int32_t, 3> cell;
    for (int k = 0; k < 3; ++k) {
      cell[k] = static_cast<int32_t>(
          static_cast<int64_t>(std::floor(static_cast<double>(x[k]) * cells_per_unit_)) & 0x1FFFFF);
    }
    return cell;
  }
  static uint64_t Key(int32_t x, int32_t y, int32_t z) {
    const auto bits = [](int32_t value) { return static_cast<uint64_t>(value & 0x1FFFFF); };
    return bits(x) | bits(y) << 21 | bits(z) << 42;
  }
  uint64_t FirstSlot(uint64_t key) const { return (key * 0x9E3779B97F4A7C15ull) >> shift_; }
  size_t Slot(uint64_t key) const {
    uint64_t slot = FirstSlot(key);
    while (table_[slot].first != kNone && table_[slot].key != key)
      slot = (slot + 1) & (table_.size() - 1);
    return slot;
  }
  void Rehash(int log2_size);

  double cells_per_unit_;
  const std::vector<Eigen::Vector3f>& points_;
  std::vector<Entry> table_;
  int shift_ = 0;
  size_t num_cells_ = 0;
  std::vector<uint32_t> next_;  // by point
};

template <class Visit>
void PointGrid::ForEachNear(const Eigen::Vector3f& x, float radius, const Visit& visit) const {
  const Eigen::Vector3f r = Eigen::Vector3f::Constant(radius);
  const auto low = CellOf(x - r), high = CellOf(x + r);
  const auto count = [&](int k) { return ((high[k] - low[k]) & 0x1FFFFF) + 1; };
  const auto for_each_cell = [&](const auto& look) {
    for (int i = 0; i < count(0); ++i) {
      for (int j = 0; j < count(1); ++j) {
        for (int k = 0; k < count(2); ++k) look(Key(low[0] + i, low[1] + j, low[2] + k));
      }
    }
  };
  // The memory of all cells is asked for first.
  for_each_cell([&](uint64_t key) { __builtin_prefetch(&table_[FirstSlot(key)]); });
  for_each_cell([&](uint64_t key) {
    const Entry& entry = table_[Slot(key)];
    for (uint32_t index = entry.first; index != kNone; index = next_[index]) visit(index);
  });
}

}  // namespace lsmvs
