#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lsmvs/util/run_context.h"

namespace lsmvs {

// A node of a graph in which every node has at most four neighbours; made to be the base of a
// tetrahedron. Node x's i-th neighbour y = neighbor[i] (or kNoNeighbor) has x as its Reverse(i)-th.
struct CutNode {
  static constexpr int32_t kNoNeighbor = -1;
  // Capacities saturate here: more than any sum of weights that should be cut.
  static constexpr int32_t kMaxCapacity = 1 << 29;

  std::array<int32_t, 4> neighbor = {-1, -1, -1, -1};
  std::array<int32_t, 4> capacity =
      {};              // of the arc to each neighbour; the residual capacity after the cut
  int32_t excess = 0;  // capacity from the source if > 0, to the sink if < 0 (common part removed)
  int32_t distance =
      0;  // after the cut: > 0 on the source's side. The position in the search trees while cutting
  uint8_t reverse = 0;  // 2 bits per neighbour
  uint8_t parent = 0;   // while cutting: neighbour that is the parent in the search tree
  std::array<uint8_t, 2> unused = {};

  int Reverse(int i) const { return (reverse >> (2 * i)) & 3; }
  void SetReverse(int i, int j) {
    reverse = static_cast<uint8_t>((reverse & ~(3 << (2 * i))) | (j << (2 * i)));
  }
  bool OnSourceSide() const { return distance > 0; }
};

// Computes a maximum flow from source to sink in place, and labels the nodes: on the source's side
// are exactly those that the source still reaches, the smallest of the minimum cuts' source sides.
// Returns the value of the flow, without what `excess` has already cancelled. Exact, in integers;
// sequential; deterministic.
//
// Incremental breadth-first search: two trees of shortest residual paths grow from source and sink,
// level by level; where they touch, flow is pushed; nodes cut off look for a new parent one level
// up, or are relabelled.
//   A. Goldberg, S. Hed, H. Kaplan, R. Tarjan, R. Werneck: Maximum flows by incremental
//   breadth-first search, ESA 2011.
// Deviations: four arcs a node make lists of children and current arcs superfluous; of what falls
// off a tree, each node is given its new level once, as by a breadth-first search from what is
// left. O(n^2 m) at worst, near linear on the graphs that visibility makes. Memory: the nodes, and
// about 8 bytes per node for the frontiers. `Node` is CutNode or derived from it. Throws
// CancelledError.
//
// With fewer than all nodes in a part, parts of `part_size` consecutive nodes are cut one after the
// other, each with the arcs that leave it switched off; then these are switched on and the flow is
// augmented across the walls, which touches little more than the nodes near them. The result is the
// same: for nodes that do not fit into memory and lie so that neighbours are close.
//   J. Liu, J. Sun: Parallel graph-cuts by adaptive bottom-up merging, CVPR 2010.
inline constexpr size_t kAllNodes = static_cast<size_t>(-1);
template <class Node>
int64_t MaximizeFlow(std::vector<Node>* nodes, const RunContext& context,
                     size_t part_size = kAllNodes);

}  // namespace lsmvs
