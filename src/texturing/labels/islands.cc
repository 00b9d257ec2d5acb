#include "lsmvs/texturing/labels/islands.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

constexpr int kSweeps = 2;  // islands of several photos become one at first

struct Island {
  double area_px = 0;
  std::vector<uint32_t> faces;
};

// Connected faces of the same view.
DisjointSets Regions(const LabelEnergy& energy, const ViewSlots& slots) {
  DisjointSets regions(slots.size());
  for (uint32_t f = 0; f < slots.size(); ++f) {
    for (const int32_t other : energy.neighbors()[f]) {
      if (other < 0 || slots[f] == kNoSlot) continue;
      const auto g = static_cast<uint32_t>(other);
      if (energy.ViewOf(slots, f) == energy.ViewOf(slots, g)) regions.Unite(f, g);
    }
  }
  return regions;
}

// The smallest first.
std::vector<Island> FindIslands(const LabelEnergy& energy, double min_area_px,
                                const ViewSlots& slots) {
  DisjointSets regions = Regions(energy, slots);
  std::vector<double> area_px(slots.size(), 0.0);
  for (uint32_t f = 0; f < slots.size(); ++f) area_px[regions.Find(f)] += energy.AreaPx(f);
  std::map<uint32_t, Island> by_region;
  for (uint32_t f = 0; f < slots.size(); ++f) {
    const uint32_t region = regions.Find(f);
    if (slots[f] == kNoSlot || area_px[region] >= min_area_px) continue;
    Island& island = by_region[region];
    island.area_px = area_px[region];
    island.faces.push_back(f);
  }
  std::vector<Island> islands;
  for (auto& [region, island] : by_region) islands.push_back(std::move(island));
  std::stable_sort(islands.begin(), islands.end(),
                   [](const Island& a, const Island& b) { return a.area_px < b.area_px; });
  return islands;
}

class IslandAbsorber {
 public:
  IslandAbsorber(const LabelEnergy& energy, ViewSlots* slots) : energy_(energy), slots_(*slots) {}

  // False if no neighbour shows all of it.
  bool Absorb(const Island& island) {
    const std::optional<int> view_idx = BestNeighbor(island.faces);
    if (!view_idx) return false;
    for (const uint32_t f : island.faces) slots_[f] = *SlotOf(f, *view_idx);
    return true;
  }

  // Gives away the faces one by one, from the border on.
  void Erode(const Island& island) {
    const int own = energy_.ViewOf(slots_, island.faces.front());
    std::vector<uint32_t> faces = island.faces, left;
    while (true) {
      left.clear();
      for (const uint32_t& f : faces) {
        if (energy_.ViewOf(slots_, f) != own) continue;
        const std::optional<int> view_idx = BestNeighbor({&f, 1});
        if (view_idx) {
          slots_[f] = *SlotOf(f, *view_idx);
        } else {
          left.push_back(f);
        }
      }
      if (left.size() == faces.size()) return;
      faces.swap(left);
    }
  }

 private:
  // Of the views beside the faces that show all of them, the one with the longest border.
  std::optional<int> BestNeighbor(std::span<const uint32_t> faces) const {
    const int own = energy_.ViewOf(slots_, faces.front());
    std::map<int, double> borders;
    for (const uint32_t f : faces) {
      for (int side = 0; side < 3; ++side) {
        const int32_t other = energy_.neighbors()[f][static_cast<size_t>(side)];
        if (other < 0) continue;
        const int view = energy_.ViewOf(slots_, static_cast<size_t>(other));
        if (view >= 0 && view != own) borders[view] += energy_.LengthPx(f, side);
      }
    }
    std::optional<int> best;
    for (const auto& [view, length] : borders) {
      if (best && borders[*best] >= length) continue;
      if (ShowsAll(faces, view)) best = view;
    }
    return best;
  }

  bool ShowsAll(std::span<const uint32_t> faces, int view_idx) const {
    return std::all_of(faces.begin(), faces.end(),
                       [&](uint32_t f) { return SlotOf(f, view_idx).has_value(); });
  }

  std::optional<uint8_t> SlotOf(size_t face, int view_idx) const {
    const auto of_face = energy_.candidates().Of(face);
    for (size_t k = 0; k < of_face.size(); ++k) {
      if (of_face[k].view_idx == view_idx) return static_cast<uint8_t>(k);
    }
    return std::nullopt;
  }

  const LabelEnergy& energy_;
  ViewSlots& slots_;
};

}  // namespace

size_t AbsorbIslands(const LabelEnergy& energy, double min_area_px, ViewSlots* slots) {
  size_t num_absorbed = 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    IslandAbsorber absorber(energy, slots);
    for (const Island& island : FindIslands(energy, min_area_px, *slots)) {
      num_absorbed += absorber.Absorb(island) ? 1 : 0;
    }
  }
  IslandAbsorber absorber(energy, slots);
  for (const Island& island : FindIslands(energy, min_area_px, *slots)) absorber.Erode(island);
  return num_absorbed;
}

}  // namespace lsmvs
