#pragma once

// How MaximizeFlow works. To be included once for each type of node that is cut, in the .cc file
// that instantiates it.

#include <algorithm>
#include <limits>
#include <vector>

#include "lsmvs/graph/minimum_cut.h"

namespace lsmvs::internal {

// Nodes that wait to be handled in ascending order of their levels, first come first served within
// one.
class NodesByLevel {
 public:
  void Add(int32_t level, int32_t node) {
    const auto at = static_cast<size_t>(level);
    if (at >= nodes_.size()) nodes_.resize(at + 1);
    nodes_[at].push_back(node);
    lowest_ = std::min(lowest_, at);
    highest_ = std::max(highest_, at);
  }

  // Calls handle(node, level) for all, and for those of this level or above that it adds meanwhile.
  template <class Handle>
  void Drain(const Handle& handle) {
    for (size_t level = lowest_; level <= highest_; ++level) {
      for (size_t k = 0; k < nodes_[level].size(); ++k) {
        handle(nodes_[level][k], static_cast<int32_t>(level));
      }
      nodes_[level].clear();
    }
    lowest_ = std::numeric_limits<size_t>::max();
    highest_ = 0;
  }

 private:
  std::vector<std::vector<int32_t>> nodes_;
  size_t lowest_ = std::numeric_limits<size_t>::max(), highest_ = 0;
};

// See MaximizeFlow. The tree of the source is side +1, that of the sink side -1: a node's side is
// the sign of its distance, its level the absolute value; 0 is free.
template <class Node>
class BreadthFirstFlow {
 public:
  BreadthFirstFlow(std::vector<Node>* nodes, const RunContext& context)
      : nodes_(*nodes), context_(context) {}

  // In parts of `part_size` nodes.
  int64_t Run(size_t part_size) {
    const size_t num_nodes = nodes_.size();
    for (size_t begin = 0; begin < num_nodes; begin += part_size) {
      CutPart(begin, std::min(num_nodes, begin + part_size));
    }
    if (part_size < num_nodes) JoinParts(part_size);
    for (Node& node : nodes_) node.distance = node.distance > 0 ? 1 : 0;
    return flow_;
  }

 private:
  static constexpr uint8_t kTerminal = 4, kOrphan = 5;
  static constexpr int kSource = 0, kSink = 1;
  static constexpr int TreeOf(int side) { return side > 0 ? kSource : kSink; }

  // A maximum flow between the nodes [begin, end); arcs that leave them count as absent.
  void CutPart(size_t begin, size_t end) {
    begin_ = static_cast<uint32_t>(begin);
    num_inside_ = static_cast<uint32_t>(end - begin);
    level_[kSource] = level_[kSink] = 1;
    for (const int tree : {kSource, kSink}) {
      frontier_[tree].clear();
      next_[tree].clear();
    }
    Plant();
    // When the source's tree cannot grow, what it holds is the source's side.
    while (!frontier_[kSource].empty()) {
      context_.ThrowIfCancelled();
      if (SinkGrows()) {
        Grow<-1>();
      } else {
        Grow<1>();
      }
    }
  }

  bool Inside(int32_t node) const { return static_cast<uint32_t>(node) - begin_ < num_inside_; }

  // Switches the arcs between the parts on. The flow stays feasible and the trees stay trees; what
  // can break is that no residual arc leaves the source's tree. It grows from there: from one node
  // at a wall after the other, each until nothing is left to do, so that what is touched lies
  // together. Lost nodes may take any level; every node that joins or gets another level is scanned
  // again.
  void JoinParts(size_t part_size) {
    begin_ = 0;
    num_inside_ = static_cast<uint32_t>(nodes_.size());
    joining_ = true;
    const auto part_of = [&](size_t node) { return node / part_size; };
    for (size_t x = 0; x < nodes_.size(); ++x) {
      if (x % kPollEach == 0) context_.ThrowIfCancelled();
      const auto leaves = [&](int32_t y) {
        return y >= 0 && part_of(static_cast<size_t>(y)) != part_of(x);
      };
      const auto& neighbor = nodes_[x].neighbor;
      if (nodes_[x].distance <= 0 || std::none_of(neighbor.begin(), neighbor.end(), leaves)) {
        continue;
      }
      active_.assign(1, static_cast<int32_t>(x));
      for (size_t k = 0; k < active_.size(); ++k) Join(active_[k]);
    }
    active_.clear();
  }

  // Pushes what a node of the source's tree can, and takes in its free neighbours.
  void Join(int32_t x) {
    Node& node = nodes_[x];
    for (int i = 0; i < 4 && node.distance > 0; ++i) {
      const int32_t y = node.neighbor[i];
      if (y < 0) continue;
      Node& other = nodes_[y];
      while (node.distance > 0 && node.capacity[i] > 0 && other.distance <= 0) {
        if (other.distance < 0) {
          Augment(x, i);
          continue;
        }
        other.distance = node.distance + 1;
        other.parent = static_cast<uint8_t>(node.Reverse(i));
        active_.push_back(y);
      }
    }
  }

  // The smaller frontier grows; but a tree much deeper than the other waits: where little flow is
  // left and ways are long, what hangs on a node that is cut off goes with the square of the depth.
  bool SinkGrows() const {
    if (frontier_[kSink].empty()) return false;
    if (level_[kSink] < level_[kSource]) return true;
    return frontier_[kSink].size() < frontier_[kSource].size() &&
           level_[kSink] < 2 * level_[kSource] + 14;
  }

  void Plant() {
    for (size_t x = begin_; x < begin_ + size_t{num_inside_}; ++x) {
      Node& node = nodes_[x];
      node.parent = kTerminal;
      node.distance = node.excess > 0 ? 1 : node.excess < 0 ? -1 : 0;
      if (node.distance != 0) {
        frontier_[TreeOf(node.distance)].push_back(static_cast<int32_t>(x));
      }
    }
  }

  // Residual capacity between `x` and its i-th neighbour `y` in the direction away from the root of
  // `side`'s tree.
  template <int side>
  int32_t Outward(const Node& x, int i, const Node& y) const {
    return side > 0 ? x.capacity[i] : y.capacity[x.Reverse(i)];
  }

  template <int side>
  void Grow() {
    constexpr int tree = TreeOf(side);
    growing_ = tree;
    const int32_t distance = side * level_[tree];
    // Relabelled nodes join the list while it is walked through.
    for (size_t k = 0; k < frontier_[tree].size(); ++k) {
      const int32_t x = frontier_[tree][k];
      if (nodes_[x].distance == distance) ScanNode<side>(x);
    }
    frontier_[tree].swap(next_[tree]);
    next_[tree].clear();
    ++level_[tree];
    growing_ = -1;
  }

  template <int side>
  void ScanNode(int32_t x) {
    constexpr int tree = TreeOf(side);
    Node& node = nodes_[x];
    const int32_t distance = node.distance;
    for (int i = 0; i < 4; ++i) {
      const int32_t y = node.neighbor[i];
      if (!Inside(y)) continue;
      Node& other = nodes_[y];
      while (Outward<side>(node, i, other) > 0) {
        if (other.distance == 0) {
          other.distance = distance + side;
          other.parent = static_cast<uint8_t>(node.Reverse(i));
          next_[tree].push_back(y);
          break;
        }
        if ((other.distance > 0) == (side > 0)) break;
        if (side > 0) {
          Augment(x, i);
        } else {
          Augment(y, node.Reverse(i));
        }
        if (node.distance != distance) return;
      }
    }
  }

  // Pushes what the path root - x - its i-th neighbour - root takes.
  void Augment(int32_t x, int i) {
    const int32_t y = nodes_[x].neighbor[i];
    int32_t amount = nodes_[x].capacity[i];
    amount = std::min(amount, Bottleneck<1>(x));
    amount = std::min(amount, Bottleneck<-1>(y));
    nodes_[x].capacity[i] -= amount;
    nodes_[y].capacity[nodes_[x].Reverse(i)] += amount;
    flow_ += amount;
    Push<1>(x, amount);
    Adopt<1>();
    Push<-1>(y, amount);
    Adopt<-1>();
  }

  template <int side>
  int32_t Bottleneck(int32_t x) const {
    int32_t amount = std::numeric_limits<int32_t>::max();
    while (nodes_[x].parent != kTerminal) {
      const Node& node = nodes_[x];
      const Node& parent = nodes_[node.neighbor[node.parent]];
      amount = std::min(amount, side > 0 ? parent.capacity[node.Reverse(node.parent)]
                                         : node.capacity[node.parent]);
      x = node.neighbor[node.parent];
    }
    return std::min(amount, std::abs(nodes_[x].excess));
  }

  template <int side>
  void Push(int32_t x, int32_t amount) {
    while (nodes_[x].parent != kTerminal) {
      Node& node = nodes_[x];
      const int32_t up = node.neighbor[node.parent];
      int32_t& upward = node.capacity[node.parent];
      int32_t& downward = nodes_[up].capacity[node.Reverse(node.parent)];
      upward += side * amount;
      downward -= side * amount;
      if ((side > 0 ? downward : upward) == 0) MakeOrphan<side>(x);
      x = up;
    }
    nodes_[x].excess -= side * amount;
    if (nodes_[x].excess == 0) MakeOrphan<side>(x);
  }

  template <int side>
  void MakeOrphan(int32_t x) {
    nodes_[x].parent = kOrphan;
    orphans_.Add(side * nodes_[x].distance, x);
  }

  // Finds parents for the orphans of one tree. First, nearest to the root first, those that have
  // another neighbour one level up keep their level; the others are lost, with what hung on them.
  // Then the lost get their new levels from those that were not, nearest to the root first: each
  // once, however much of the tree fell off.
  template <int side>
  void Adopt() {
    lost_.clear();
    orphans_.Drain([&](int32_t x, int32_t level) {
      if (!FindParent<side>(x, level - 1)) Lose<side>(x);
    });
    for (const int32_t x : lost_) {
      if (const int32_t level = LevelOf<side>(x); level > 0) relabelled_.Add(level, x);
    }
    relabelled_.Drain([&](int32_t x, int32_t level) {
      if (nodes_[x].distance == 0) Relabel<side>(x, level);
    });
  }

  // The i-th neighbour of x, if it is in the tree of `side` and could be a parent: its level; else
  // 0.
  template <int side>
  int32_t LevelOfParent(const Node& x, int i) const {
    const int32_t y = x.neighbor[i];
    if (!Inside(y)) return 0;
    const Node& other = nodes_[y];
    const int32_t inward = side > 0 ? other.capacity[x.Reverse(i)] : x.capacity[i];
    return inward > 0 ? std::max(0, side * other.distance) : 0;
  }

  template <int side>
  bool FindParent(int32_t x, int32_t level) {
    if (level == 0) return false;
    Node& node = nodes_[x];
    for (uint8_t i = 0; i < 4; ++i) {
      if (LevelOfParent<side>(node, i) != level) continue;
      node.parent = i;
      return true;
    }
    return false;
  }

  template <int side>
  void Lose(int32_t x) {
    DisownChildren<side>(x);
    nodes_[x].distance = 0;
    nodes_[x].parent = kTerminal;
    lost_.push_back(x);
  }

  // One below the best parent of a lost node, or 0 if there is none within the tree's levels.
  template <int side>
  int32_t LevelOf(int32_t x) const {
    int32_t best = std::numeric_limits<int32_t>::max();
    for (int i = 0; i < 4; ++i) {
      if (const int32_t level = LevelOfParent<side>(nodes_[x], i); level > 0) {
        best = std::min(best, level);
      }
    }
    return best < Limit<side>() ? best + 1 : 0;
  }

  // Levels of the tree that are complete, or being made.
  template <int side>
  int32_t Limit() const {
    if (joining_) return std::numeric_limits<int32_t>::max();
    constexpr int tree = TreeOf(side);
    return level_[tree] + (growing_ == tree ? 1 : 0);
  }

  template <int side>
  void Relabel(int32_t x, int32_t level) {
    constexpr int tree = TreeOf(side);
    FindParent<side>(x, level - 1);
    Node& node = nodes_[x];
    node.distance = side * level;
    if (joining_) {
      if (side > 0) active_.push_back(x);
    } else if (level == level_[tree]) {
      frontier_[tree].push_back(x);
    } else if (level == level_[tree] + 1) {
      next_[tree].push_back(x);
    }
    if (level >= Limit<side>()) return;
    for (int i = 0; i < 4; ++i) {
      const int32_t y = node.neighbor[i];
      if (Inside(y) && nodes_[y].distance == 0 && Outward<side>(node, i, nodes_[y]) > 0) {
        relabelled_.Add(level + 1, y);
      }
    }
  }

  template <int side>
  void DisownChildren(int32_t x) {
    const Node& node = nodes_[x];
    for (int i = 0; i < 4; ++i) {
      const int32_t y = node.neighbor[i];
      if (!Inside(y)) continue;
      const Node& other = nodes_[y];
      if (side * other.distance > 0 && other.parent == node.Reverse(i)) MakeOrphan<side>(y);
    }
  }

  static constexpr size_t kPollEach = 1 << 16;

  std::vector<Node>& nodes_;
  const RunContext& context_;
  uint32_t begin_ = 0, num_inside_ = 0;  // the nodes that are cut at present
  bool joining_ = false;                 // the parts are cut and are being joined
  std::vector<int32_t> active_;          // nodes to scan while joining
  std::vector<int32_t> frontier_[2],
      next_[2];  // nodes of the level that grows next, and of the one after
  int32_t level_[2] = {1, 1};
  int growing_ = -1;
  NodesByLevel orphans_, relabelled_;
  std::vector<int32_t> lost_;
  int64_t flow_ = 0;
};

}  // namespace lsmvs::internal

namespace lsmvs {

template <class Node>
int64_t MaximizeFlow(std::vector<Node>* nodes, const RunContext& context, size_t part_size) {
  return internal::BreadthFirstFlow<Node>(nodes, context).Run(std::max<size_t>(1, part_size));
}

}  // namespace lsmvs
