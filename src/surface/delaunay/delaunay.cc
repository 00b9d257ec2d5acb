#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "lsmvs/surface/delaunay/geometric_predicates.h"
#include "lsmvs/surface/tetrahedralization.h"
#include "lsmvs/util/scratch_memory.h"

namespace lsmvs {

namespace {

using internal::InSphere;
using internal::Orientation;

constexpr int kNumRounds = 12, kNumSampleRounds = 6;  // the sample is a 64th
constexpr size_t kTile = 1 << 14;                     // vertices
constexpr size_t kReportEach = 1 << 16;
constexpr int32_t kFreeCell = -2;  // as vertex[0] of a cell that is not in use

// Round in which a vertex is inserted: half of all are in the last one, half of the rest in the one
// before, and so on.
int RoundOf(size_t vertex) {
  const uint64_t hash = (vertex + 1) * 0x9E3779B97F4A7C15ull;
  return kNumRounds - 1 - std::min(kNumRounds - 1, std::countr_one(hash >> 20));
}

// Biased randomised insertion order. First a sparse sample of all, round by round; then one tile of
// consecutive vertices after the other, each round by round. So the work goes through the data once
// in spatial order, whatever their number: what a tile needs fits into the cache, and the cells are
// made nearly in the order in which they will lie.
std::vector<uint32_t> InsertionOrder(size_t count) {
  std::vector<uint32_t> order;
  order.reserve(count);
  for (int round = 0; round < kNumSampleRounds; ++round) {
    for (size_t i = 0; i < count; ++i) {
      if (RoundOf(i) == round) order.push_back(static_cast<uint32_t>(i));
    }
  }
  for (size_t begin = 0; begin < count; begin += kTile) {
    const size_t end = std::min(count, begin + kTile);
    for (int round = kNumSampleRounds; round < kNumRounds; ++round) {
      for (size_t i = begin; i < end; ++i) {
        if (RoundOf(i) == round) order.push_back(static_cast<uint32_t>(i));
      }
    }
  }
  return order;
}

int InfiniteIndex(const Cell& cell) {
  for (int k = 0; k < 4; ++k) {
    if (cell.vertex[k] == Cell::kInfiniteVertex) return k;
  }
  return -1;
}

int OrientationOfFacet(const Tetrahedralization& complex, const Cell& cell, int i,
                       const Eigen::Vector3f& x) {
  const auto& facet = kFacetVertices[i];
  const auto at = [&](int k) -> const Eigen::Vector3f& {
    return complex.points[cell.vertex[facet[k]]];
  };
  return Orientation(at(0), at(1), at(2), x);
}

// Incremental construction (A. Bowyer; D. Watson, 1981): the cells whose circumspheres hold the new
// point make room for its star. Ties of cospherical points are broken by a perturbation that
// depends on coordinates only (O. Devillers, M. Teillaud: Perturbations for Delaunay and weighted
// Delaunay 3D triangulations, 2011), so the result does not depend on the order of insertion. While
// it runs, a cell's `distance` is a mark and capacity[i] the new cell behind facet i.
class DelaunayBuilder {
 public:
  explicit DelaunayBuilder(std::vector<Eigen::Vector3f> points) : points_(complex_.points) {
    complex_.points = std::move(points);
    complex_.incident_cell.assign(points_.size(), -1);
  }

  Tetrahedralization Run(const RunContext& context) {
    std::vector<uint32_t> order = InsertionOrder(points_.size());
    if (!InsertFirstCell(&order)) return std::move(complex_);
    cells_.reserve(points_.size() * 69 / 10 + 64);
    for (size_t i = 0; i < order.size(); ++i) {
      if (order[i] != kInserted) Insert(static_cast<int32_t>(order[i]));
      if (i % kReportEach == 0) {
        context.ThrowIfCancelled();
        context.Report(static_cast<double>(i) / static_cast<double>(order.size()));
      }
    }
    std::vector<uint32_t>().swap(order);
    SortCells();
    FindIncidentCells();
    std::sort(complex_.duplicates.begin(), complex_.duplicates.end());
    return std::move(complex_);
  }

 private:
  static constexpr uint32_t kInserted = std::numeric_limits<uint32_t>::max();

  const Eigen::Vector3f& At(int32_t vertex) const { return points_[vertex]; }

  // Takes the first four points that are not in one plane out of `order`. False if there are none.
  bool InsertFirstCell(std::vector<uint32_t>* order) {
    std::vector<int32_t> corners;
    for (uint32_t& p : *order) {
      corners.push_back(static_cast<int32_t>(p));
      if (!Independent(corners)) {
        corners.pop_back();
        continue;
      }
      p = kInserted;
      if (corners.size() == 4) break;
    }
    if (corners.size() < 4) return false;
    if (Orientation(At(corners[0]), At(corners[1]), At(corners[2]), At(corners[3])) < 0) {
      std::swap(corners[0], corners[1]);
    }
    MakeFirstCells(corners);
    return true;
  }

  bool Independent(const std::vector<int32_t>& v) const {
    if (v.size() == 2) return At(v[0]) != At(v[1]);
    if (v.size() == 4) return Orientation(At(v[0]), At(v[1]), At(v[2]), At(v[3])) != 0;
    if (v.size() < 3) return true;
    // Not in one line: some plane through a point off the axes tells them apart.
    const Eigen::Vector3f& a = At(v[0]);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f off = a + Eigen::Vector3f::Unit(k);
      if (Orientation(a, At(v[1]), At(v[2]), off) != 0) return true;
    }
    return false;
  }

  void MakeFirstCells(const std::vector<int32_t>& corners) {
    cells_.resize(5);
    for (int k = 0; k < 4; ++k) cells_[0].vertex[k] = corners[k];
    for (int k = 0; k < 4; ++k) {
      // Cell k + 1 lies behind facet k: the same facet the other way round, and infinity.
      Cell& outer = cells_[k + 1];
      for (int i = 0; i < 3; ++i) outer.vertex[i] = corners[kFacetVertices[k][i]];
      std::swap(outer.vertex[0], outer.vertex[1]);
      outer.vertex[3] = Cell::kInfiniteVertex;
      Link(0, k, k + 1, 3);
    }
    for (int32_t a = 1; a < 5; ++a) {
      for (int32_t b = 1; b < 5; ++b) {
        if (a == b) continue;
        // They share the edge of the corners that are neither a - 1 nor b - 1.
        Link(a, cells_[a].IndexOfVertex(corners[b - 1]), b,
             cells_[b].IndexOfVertex(corners[a - 1]));
      }
    }
  }

  void Link(int32_t a, int i, int32_t b, int j) {
    cells_[a].neighbor[i] = b;
    cells_[a].SetReverse(i, j);
    cells_[b].neighbor[j] = a;
    cells_[b].SetReverse(j, i);
  }

  bool InConflict(const Cell& cell, int32_t p) const {
    if (const int k = InfiniteIndex(cell); k >= 0) {
      const int side = OrientationOfFacet(complex_, cell, k, At(p));
      return side > 0 || (side == 0 && InConflict(cells_[cell.neighbor[k]], p));
    }
    const auto& v = cell.vertex;
    const int side = InSphere(At(v[0]), At(v[1]), At(v[2]), At(v[3]), At(p));
    return side != 0 ? side > 0 : InPerturbedSphere(v, p);
  }

  bool InPerturbedSphere(const std::array<int32_t, 4>& v, int32_t p) const {
    std::array<int, 5> order = {0, 1, 2, 3, 4};  // 4 is p
    const auto at = [&](int i) -> const Eigen::Vector3f& { return At(i == 4 ? p : v[i]); };
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      return std::lexicographical_compare(at(a).begin(), at(a).end(), at(b).begin(), at(b).end());
    });
    for (int i = 4; i > 2; --i) {
      if (order[i] == 4) return false;
      std::array<int32_t, 4> w = v;
      w[order[i]] = p;
      const int side = Orientation(At(w[0]), At(w[1]), At(w[2]), At(w[3]));
      if (side != 0) return side > 0;
    }
    return false;
  }

  void Insert(int32_t p) {
    const int32_t start = LocateCell(complex_, At(p), hint_);  // from the last cell made
    for (const int32_t v : cells_[start].vertex) {
      if (v < 0 || At(v) != At(p)) continue;
      complex_.duplicates.push_back({p, v});
      return;
    }
    FindConflicts(start, p);
    MakeStar(p);
    for (const Side& side : boundary_) LinkStar(side);
    for (const int32_t c : conflicts_) {
      cells_[c].vertex[0] = kFreeCell;
      free_.push_back(c);
    }
  }

  struct Side {
    int32_t cell;
    int facet;
  };

  void FindConflicts(int32_t start, int32_t p) {
    mark_ += 2;  // mark_: in conflict; mark_ + 1: not
    conflicts_.assign(1, start);
    boundary_.clear();
    cells_[start].distance = mark_;
    for (size_t k = 0; k < conflicts_.size(); ++k) {
      const int32_t c = conflicts_[k];
      for (int i = 0; i < 4; ++i) {
        const int32_t next = cells_[c].neighbor[i];
        int32_t& mark = cells_[next].distance;
        if (mark < mark_) {
          mark = mark_ + (InConflict(cells_[next], p) ? 0 : 1);
          if (mark == mark_) {
            conflicts_.push_back(next);
            for (const int32_t n : cells_[next].neighbor) __builtin_prefetch(&cells_[n]);
          }
        }
        if (mark != mark_) boundary_.push_back({c, i});
      }
    }
  }

  void MakeStar(int32_t p) {
    for (const Side& side : boundary_) {
      int32_t made;
      if (free_.empty()) {
        made = static_cast<int32_t>(cells_.size());
        cells_.emplace_back();
      } else {
        made = free_.back();
        free_.pop_back();
      }
      Cell& old = cells_[side.cell];
      Cell& cell = cells_[made];
      cell.vertex = old.vertex;
      cell.vertex[side.facet] = p;
      cell.distance = 0;
      old.capacity[side.facet] = made;
      Link(made, side.facet, old.neighbor[side.facet], old.Reverse(side.facet));
      hint_ = made;
    }
  }

  // Links the new cell behind a side of the hole to those behind the sides next to it.
  void LinkStar(const Side& side) {
    const int32_t made = cells_[side.cell].capacity[side.facet];
    for (int j = 0; j < 4; ++j) {
      if (j == side.facet) continue;
      // Around the edge opposite to facet and j, through the hole, until it ends.
      const int e = kEdgeOpposite[side.facet][j][0], f = kEdgeOpposite[side.facet][j][1];
      const int32_t a = cells_[side.cell].vertex[e], b = cells_[side.cell].vertex[f];
      int32_t current = side.cell;
      int from = side.facet, to = j;
      while (cells_[cells_[current].neighbor[to]].distance == mark_) {
        from = cells_[current].Reverse(to);
        current = cells_[current].neighbor[to];
        const auto& v = cells_[current].vertex;
        to = 0;
        while (to == from || v[to] == a || v[to] == b) ++to;
      }
      Cell& cell = cells_[made];
      cell.neighbor[j] = cells_[current].capacity[to];
      cell.SetReverse(j, from);
    }
  }

  static constexpr int kEdgeOpposite[4][4][2] = {{{0, 0}, {2, 3}, {1, 3}, {1, 2}},
                                                 {{2, 3}, {0, 0}, {0, 3}, {0, 2}},
                                                 {{1, 3}, {0, 3}, {0, 0}, {0, 1}},
                                                 {{1, 2}, {0, 2}, {0, 1}, {0, 0}}};

  static int32_t LowestVertex(const Cell& cell) {
    int32_t lowest = std::numeric_limits<int32_t>::max();
    for (const int32_t v : cell.vertex) {
      if (v >= 0) lowest = std::min(lowest, v);
    }
    return lowest;
  }

  // Drops unused cells and numbers the others: finite ones first. They were made nearly in the
  // order of their vertices; within windows they are put into the order of their lowest one, so
  // that neighbours lie close. Goes through the cells once, in place.
  void SortCells() {
    constexpr size_t kWindow = 1 << 17;
    std::vector<int32_t> new_index(cells_.size(), -1);
    std::vector<Cell> infinite;
    std::vector<int32_t> infinite_index, window;
    size_t num_sorted = 0;
    for (size_t c = 0; c < cells_.size(); ++c) {
      const Cell& cell = cells_[c];
      if (cell.vertex[0] != kFreeCell) {
        if (InfiniteIndex(cell) < 0) {
          window.push_back(static_cast<int32_t>(c));
        } else {
          infinite.push_back(cell);
          infinite_index.push_back(static_cast<int32_t>(c));
        }
      }
      if (window.size() == kWindow || c + 1 == cells_.size()) {
        SortWindow(window, num_sorted, &new_index);
        num_sorted += window.size();
        window.clear();
      }
    }
    complex_.num_finite_cells = num_sorted;
    cells_.resize(num_sorted);
    for (size_t i = 0; i < infinite.size(); ++i) {
      new_index[infinite_index[i]] = static_cast<int32_t>(cells_.size());
      cells_.push_back(infinite[i]);
    }
    // More were reserved than came.
    ScratchMemory::GiveBackTail(cells_.data(), cells_.size() * sizeof(Cell));
    for (Cell& cell : cells_) {
      for (int32_t& neighbor : cell.neighbor) neighbor = new_index[neighbor];
      cell.capacity = {};
      cell.excess = cell.distance = 0;
    }
  }

  // Puts the cells of the window, which lie at or behind `begin`, to `begin` and on.
  void SortWindow(const std::vector<int32_t>& window, size_t begin,
                  std::vector<int32_t>* new_index) {
    std::vector<std::pair<int32_t, int32_t>> order;
    for (const int32_t c : window) order.emplace_back(LowestVertex(cells_[c]), c);
    std::sort(order.begin(), order.end());
    std::vector<Cell> sorted;
    sorted.reserve(order.size());
    for (const auto& [lowest, c] : order) {
      (*new_index)[c] = static_cast<int32_t>(begin + sorted.size());
      sorted.push_back(cells_[c]);
    }
    std::copy(sorted.begin(), sorted.end(), cells_.begin() + static_cast<std::ptrdiff_t>(begin));
  }

  void FindIncidentCells() {
    for (size_t c = complex_.num_finite_cells; c-- > 0;) {
      for (const int32_t v : cells_[c].vertex) complex_.incident_cell[v] = static_cast<int32_t>(c);
    }
  }

  Tetrahedralization complex_;
  const std::vector<Eigen::Vector3f>& points_;
  std::vector<Cell>& cells_ = complex_.cells;
  int32_t hint_ = 0;
  int32_t mark_ = 0;
  std::vector<int32_t> conflicts_, free_;
  std::vector<Side> boundary_;
};

}  // namespace

Tetrahedralization BuildDelaunay(std::vector<Eigen::Vector3f> points, const RunContext& context) {
  return DelaunayBuilder(std::move(points)).Run(context);
}

// Across facets that part the cell from x; in a Delaunay complex such walks end.
int32_t LocateCell(const Tetrahedralization& complex, const Eigen::Vector3f& x, int32_t start) {
  int32_t current = start;
  const std::vector<Cell>& cells = complex.cells;
  if (const int k = InfiniteIndex(cells[current]); k >= 0) current = cells[current].neighbor[k];
  int entry = -1;
  while (true) {
    const Cell& cell = cells[current];
    int exit = 0;
    while (exit < 4 && (exit == entry || OrientationOfFacet(complex, cell, exit, x) >= 0)) ++exit;
    if (exit == 4) return current;
    entry = cell.Reverse(exit);
    current = cell.neighbor[exit];
    if (InfiniteIndex(cells[current]) >= 0) return current;
  }
}

}  // namespace lsmvs
