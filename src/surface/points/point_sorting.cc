#include "lsmvs/surface/points/point_sorting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/util/scratch_memory.h"
#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

// Cells along a Hilbert curve. Most points have cells of their own; those far out share the cells
// at the border.
class PlaceGrid {
 public:
  explicit PlaceGrid(const VisibilityCloud& cloud) {
    // Finer where the cells of a flat scene would be much of the memory.
    constexpr size_t kManyPoints = 1 << 24;
    bits_ = cloud.size() > kManyPoints ? 7 : 6;
    double size = 0;
    for (int k = 0; k < 3; ++k) {
      std::vector<float> values = SampleAxis(cloud, k);
      if (values.empty()) continue;
      const size_t margin = values.size() / 50;
      low_[k] = ValueOfRank(&values, margin);
      size = std::max(size, ValueOfRank(&values, values.size() - 1 - margin) - low_[k]);
    }
    steps_per_unit_ = size > 0 ? (1 << kHilbertBits) / size : 0;
  }

  size_t num_cells() const { return size_t{1} << (3 * bits_); }

  uint32_t CellOf(const Eigen::Vector3f& x) const {
    constexpr double kLastStep = (1 << kHilbertBits) - 1;
    std::array<uint32_t, 3> steps;
    for (int k = 0; k < 3; ++k) {
      const double step = steps_per_unit_ * (static_cast<double>(x[k]) - low_[k]);
      steps[k] = step > 0 ? static_cast<uint32_t>(std::min(step, kLastStep)) : 0;  // also if NaN
    }
    return static_cast<uint32_t>(HilbertIndex(steps) >> (3 * (kHilbertBits - bits_)));
  }

 private:
  static std::vector<float> SampleAxis(const VisibilityCloud& cloud, int axis) {
    constexpr size_t kMaxSample = 20000;
    std::vector<float> values;
    for (size_t p = 0; p < cloud.size(); p += cloud.size() / kMaxSample + 1) {
      if (cloud.positions[p].allFinite()) values.push_back(cloud.positions[p][axis]);
    }
    return values;
  }

  int bits_;
  std::array<double, 3> low_ = {};
  double steps_per_unit_ = 0;
};

std::vector<uint32_t> FindPlaces(const VisibilityCloud& cloud) {
  const PlaceGrid grid(cloud);
  std::vector<uint32_t> places(cloud.size()), begin(grid.num_cells() + 1, 0);
  for (size_t p = 0; p < cloud.size(); ++p) {
    places[p] = grid.CellOf(cloud.positions[p]);
    ++begin[places[p] + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  for (uint32_t& place : places) place = begin[place]++;
  return places;
}

// Runs of places, so many that each is open for appending, and a whole one for access in any order,
// in a part of the memory.
class PlaceRuns {
 public:
  PlaceRuns(size_t num_points, size_t num_bytes) {
    constexpr size_t kChunk = 2 << 20, kMinRuns = 4, kMaxRuns = 256, kShare = 4;
    const size_t memory =
        ScratchMemory::IsOn() ? ScratchMemory::MaxBytesInMemory() : size_t{1} << 30;
    const size_t open = memory / kShare / kChunk, needed = num_bytes * 2 * kShare / memory + 1;
    size_t num_runs = std::clamp(needed, size_t{1}, std::clamp(open, kMinRuns, kMaxRuns));
    length_ = std::max<size_t>(1, (num_points + num_runs - 1) / num_runs);
    num_points_ = num_points;
  }

  size_t count() const { return (num_points_ + length_ - 1) / length_; }
  size_t Begin(size_t run) const { return std::min(run * length_, num_points_); }
  size_t RunOf(size_t place) const { return place / length_; }

 private:
  size_t num_points_, length_;
};

// Moves values[p] to places[p].
template <class Value>
void Permute(const std::vector<uint32_t>& places, std::vector<Value>* values) {
  struct Item {
    uint32_t place;
    Value value;
  };
  const PlaceRuns runs(places.size(), places.size() * sizeof(Item));
  std::vector<Item> items(places.size());
  std::vector<size_t> end;
  for (size_t run = 0; run < runs.count(); ++run) end.push_back(runs.Begin(run));
  for (size_t p = 0; p < places.size(); ++p) {
    items[end[runs.RunOf(places[p])]++] = {places[p], (*values)[p]};
  }
  for (const Item& item : items) (*values)[item.place] = item.value;
}

void PermuteViews(const std::vector<uint32_t>& places, VisibilityCloud* cloud) {
  std::vector<uint64_t>& begin = cloud->view_begin;
  std::vector<uint32_t>& views = cloud->view_idxs;
  std::vector<uint32_t> counts(places.size());
  for (size_t p = 0; p < places.size(); ++p) {
    counts[p] = static_cast<uint32_t>(begin[p + 1] - begin[p]);
  }
  Permute(places, &counts);
  // Of each run, its points with place and views, one behind the other.
  const PlaceRuns runs(places.size(), sizeof(uint32_t) * (places.size() + views.size()));
  std::vector<uint32_t> items(places.size() + views.size());
  std::vector<size_t> run_begin = {0};
  for (size_t run = 0; run < runs.count(); ++run) {
    size_t size = 0;
    for (size_t i = runs.Begin(run); i < runs.Begin(run + 1); ++i) size += 1 + counts[i];
    run_begin.push_back(run_begin.back() + size);
  }
  std::vector<size_t> end = run_begin;
  for (size_t p = 0; p < places.size(); ++p) {
    size_t& at = end[runs.RunOf(places[p])];
    items[at++] = places[p];
    for (const uint32_t view_idx : cloud->ViewsOf(p)) items[at++] = view_idx;
  }
  for (size_t i = 0; i < counts.size(); ++i) begin[i + 1] = begin[i] + counts[i];
  for (size_t at = 0; at < items.size();) {
    const uint32_t place = items[at++], count = counts[place];
    std::copy_n(items.begin() + static_cast<std::ptrdiff_t>(at), count,
                views.begin() + static_cast<std::ptrdiff_t>(begin[place]));
    at += count;
  }
}

}  // namespace

std::vector<uint32_t> SortByPlace(VisibilityCloud* cloud, const RunContext& context) {
  std::vector<uint32_t> places = FindPlaces(*cloud);
  context.ThrowIfCancelled();
  Permute(places, &cloud->positions);
  context.ThrowIfCancelled();
  Permute(places, &cloud->normals);
  context.ThrowIfCancelled();
  Permute(places, &cloud->colors);
  context.ThrowIfCancelled();
  PermuteViews(places, cloud);
  return places;
}

}  // namespace lsmvs
