#include "lsmvs/merging/seam/conflicts.h"

#include <algorithm>
#include <array>
#include <map>

#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

size_t Index(int32_t i) { return static_cast<size_t>(i); }

// Collects the vertices of each conflict, and what they are worth.
class ConflictCourt {
 public:
  ConflictCourt(const ConflictWorth& worth, double max_edges, OverlapSide* first,
                OverlapSide* second)
      : worth_(worth),
        max_edges_(max_edges),
        sides_{first, second},
        begin_{0, first->states.size()},
        groups_(first->states.size() + second->states.size()) {}

  void Run() {
    for (int side = 0; side < 2; ++side) UniteConflicts(side);
    for (int side = 0; side < 2; ++side) AddWorths(side);
    if (!sums_.empty()) overall_ = {MeanWorth(0), MeanWorth(1)};
    for (int side = 0; side < 2; ++side) {
      OverlapSide& own = *sides_[side];
      for (size_t v = 0; v < own.states.size(); ++v) {
        if (own.nearest_conflict[v] < 0) continue;
        own.first_wins[v] = FirstWins(sums_[groups_.Find(Node(side, own.nearest_conflict[v]))]);
      }
    }
  }

 private:
  // Of one conflict, by side.
  struct Sums {
    std::array<double, 2> inside = {}, around = {};
    std::array<size_t, 2> num_inside = {}, num_around = {};
  };

  uint32_t Node(int side, int32_t v) const {
    return static_cast<uint32_t>(begin_[side] + Index(v));
  }
  bool IsInConflict(int side, int32_t v) const {
    return sides_[side]->nearest_conflict[Index(v)] == v;
  }
  double WorthOf(int side, int32_t v) const {
    const BandSurface& surface = *sides_[side]->surface;
    return worth_(surface.band->sources[Index(v)], surface.frames.edge_length[Index(v)]);
  }

  // Calls visit(v, w) for each vertex v in conflict and each neighbour w outside that has a match.
  template <class Visit>
  void ForRim(int side, const Visit& visit) const {
    const OverlapSide& own = *sides_[side];
    for (size_t v = 0; v < own.states.size(); ++v) {
      const auto i = static_cast<int32_t>(v);
      if (!IsInConflict(side, i)) continue;
      own.surface->topology.ForNeighbors(i, [&](int32_t w) {
        if (!IsInConflict(side, w) && own.matches[Index(w)].face >= 0) visit(i, w);
      });
    }
  }

  void UniteConflicts(int side) {
    const OverlapSide &own = *sides_[side], &other = *sides_[1 - side];
    for (size_t v = 0; v < own.states.size(); ++v) {
      const auto i = static_cast<int32_t>(v);
      if (!IsInConflict(side, i)) continue;
      own.surface->topology.ForNeighbors(i, [&](int32_t w) {
        if (IsInConflict(side, w)) groups_.Unite(Node(side, i), Node(side, w));
      });
    }
    ForRim(side, [&](int32_t v, int32_t w) {
      const double reach = (max_edges_ + kConflictReach) * own.CoarserEdge(other, Index(w));
      for (const int u : other.surface->mesh().faces[Index(own.matches[Index(w)].face)]) {
        const int32_t there = other.nearest_conflict[Index(u)];
        if (there < 0 || other.from_conflict[Index(u)] > reach) continue;
        groups_.Unite(Node(side, v), Node(1 - side, there));
      }
    });
  }

  void AddWorths(int side) {
    if (!worth_) return;
    const OverlapSide& own = *sides_[side];
    const auto k = static_cast<size_t>(side);
    for (size_t v = 0; v < own.states.size(); ++v) {
      const auto i = static_cast<int32_t>(v);
      if (!IsInConflict(side, i)) continue;
      Sums& sums = sums_[groups_.Find(Node(side, i))];
      sums.inside[k] += WorthOf(side, i);
      ++sums.num_inside[k];
    }
    ForRim(side, [&](int32_t v, int32_t w) {
      Sums& sums = sums_[groups_.Find(Node(side, v))];
      const int32_t face = own.matches[Index(w)].face;
      for (const int u : sides_[1 - side]->surface->mesh().faces[Index(face)]) {
        sums.around[1 - k] += WorthOf(1 - side, u);
        ++sums.num_around[1 - k];
      }
    });
  }

  double MeanWorth(int side) const {
    double sum = 0;
    const size_t count = sides_[side]->states.size();
    for (size_t v = 0; v < count; ++v) sum += WorthOf(side, static_cast<int32_t>(v));
    return sum / static_cast<double>(std::max<size_t>(count, 1));
  }

  // A piece of its own has no rim: the whole of the other surface stands against it.
  bool FirstWins(const Sums& sums) const {
    const auto mean = [&](size_t k) {
      if (sums.num_inside[k] > 0) return sums.inside[k] / static_cast<double>(sums.num_inside[k]);
      if (sums.num_around[k] > 0) return sums.around[k] / static_cast<double>(sums.num_around[k]);
      return overall_[k];
    };
    return mean(0) >= mean(1);
  }

  const ConflictWorth& worth_;
  double max_edges_;
  std::array<OverlapSide*, 2> sides_;
  std::array<size_t, 2> begin_;  // of a side's vertices among the nodes
  DisjointSets groups_;
  std::map<uint32_t, Sums> sums_;  // by group
  std::array<double, 2> overall_ = {};
};

}  // namespace

void DecideConflicts(const ConflictWorth& worth, double max_edges, OverlapSide* first,
                     OverlapSide* second) {
  ConflictCourt(worth, max_edges, first, second).Run();
}

}  // namespace lsmvs
