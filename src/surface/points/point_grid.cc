#include "lsmvs/surface/points/point_grid.h"

namespace lsmvs {

PointGrid::PointGrid(float cell_size, const std::vector<Eigen::Vector3f>* points)
    : cells_per_unit_(cell_size > 0 ? 1.0 / cell_size : 1 << 20), points_(*points) {
  Rehash(10);
}

void PointGrid::Rehash(int log2_size) {
  std::vector<Entry> old(size_t{1} << log2_size);
  old.swap(table_);
  shift_ = 64 - log2_size;
  for (const Entry& entry : old) {
    if (entry.first != kNone) table_[Slot(entry.key)] = entry;
  }
}

void PointGrid::Insert(uint32_t index) {
  if (2 * (num_cells_ + 1) > table_.size()) Rehash(64 - shift_ + 1);
  const auto cell = CellOf(points_[index]);
  const uint64_t key = Key(cell[0], cell[1], cell[2]);
  Entry& entry = table_[Slot(key)];
  num_cells_ += (entry.first == kNone);
  if (next_.size() <= index) next_.resize(points_.size(), kNone);
  next_[index] = entry.first;
  entry = {key, index};
}

void PointGrid::InsertThinned(float distance) {
  for (uint32_t index = 0; index < points_.size(); ++index) {
    bool close = false;
    ForEachNear(points_[index], distance, [&](uint32_t other) {
      close = close || (points_[other] - points_[index]).norm() < distance;
    });
    if (!close) Insert(index);
  }
}

}  // namespace lsmvs
