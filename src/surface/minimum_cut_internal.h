#pragma once

#include <algorithm>
#include <limits>

#include "lsmvs/surface/minimum_cut.h"

namespace lsmvs::internal {

// See MaximizeFlow. The tree of the source is side +1, that of the sink side -1: a node's side is
// the sign of its distance, its level the absolute value; 0 is free.
template <class Node>
class BreadthFirstFlow {
 public:
  BreadthFirstFlow(std::vector<Node>* nodes, const RunContext& context)
      : nodes_(*nodes), context_(context) {}

  int64_t Run() {
    Plant();
    // The smaller frontier grows. When the source's tree cannot grow, what it holds is the source's
    // side.
    while (!frontier_[kSource].empty()) {
      context_.ThrowIfCancelled();
      const bool sink =
          !frontier_[kSink].empty() && frontier_[kSink].size() < frontier_[kSource].size();
      if (sink) {
        Grow<-1>();
      } else {
        Grow<1>();
      }
    }
    for (Node& node : nodes_) node.distance = node.distance > 0 ? 1 : 0;
    return flow_;
  }

 private:
  static constexpr uint8_t kTerminal = 4, kOrphan = 5;
  static constexpr int kSource = 0, kSink = 1;
  static constexpr int TreeOf(int side) { return side > 0 ? kSource : kSink; }

  void Plant() {
    for (size_t x = 0; x < nodes_.size(); ++x) {
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
      if (y < 0) continue;
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
    const size_t level = static_cast<size_t>(side * nodes_[x].distance);
    if (level >= orphans_.size()) orphans_.resize(level + 1);
    orphans_[level].push_back(x);
    lowest_ = std::min(lowest_, level);
    highest_ = std::max(highest_, level);
  }

  // Finds parents for the orphans of one tree, nearest to the root first.
  template <int side>
  void Adopt() {
    for (size_t level = lowest_; level <= highest_; ++level) {
      for (size_t k = 0; k < orphans_[level].size(); ++k) FindParent<side>(orphans_[level][k]);
      orphans_[level].clear();
    }
    lowest_ = std::numeric_limits<size_t>::max();
    highest_ = 0;
  }

  template <int side>
  void FindParent(int32_t x) {
    constexpr int tree = TreeOf(side);
    Node& node = nodes_[x];
    const int32_t level = side * node.distance;
    const int32_t limit = level_[tree] + (growing_ == tree ? 1 : 0);
    int32_t best_level = limit;  // a parent's level must be below
    int best = -1;
    for (int i = 0; i < 4; ++i) {
      const int32_t y = node.neighbor[i];
      if (y < 0) continue;
      const Node& other = nodes_[y];
      const int32_t other_level = side * other.distance;
      if (other_level <= 0 || other_level >= best_level) continue;
      const int32_t inward = side > 0 ? other.capacity[node.Reverse(i)] : node.capacity[i];
      if (inward == 0) continue;
      best_level = other_level;
      best = i;
      if (other_level == level - 1) {
        node.parent = static_cast<uint8_t>(i);
        return;
      }
    }
    DisownChildren<side>(x);
    if (best < 0) {
      node.distance = 0;
      node.parent = kTerminal;
      return;
    }
    node.parent = static_cast<uint8_t>(best);
    node.distance = side * (best_level + 1);
    if (best_level + 1 == level_[tree]) {
      frontier_[tree].push_back(x);
    } else if (best_level + 1 == level_[tree] + 1) {
      next_[tree].push_back(x);
    }
  }

  template <int side>
  void DisownChildren(int32_t x) {
    const Node& node = nodes_[x];
    for (int i = 0; i < 4; ++i) {
      const int32_t y = node.neighbor[i];
      if (y < 0) continue;
      const Node& other = nodes_[y];
      if (side * other.distance > 0 && other.parent == node.Reverse(i)) MakeOrphan<side>(y);
    }
  }

  std::vector<Node>& nodes_;
  const RunContext& context_;
  std::vector<int32_t> frontier_[2],
      next_[2];  // nodes of the level that grows next, and of the one after
  int32_t level_[2] = {1, 1};
  int growing_ = -1;
  std::vector<std::vector<int32_t>> orphans_;  // by level
  size_t lowest_ = std::numeric_limits<size_t>::max(), highest_ = 0;
  int64_t flow_ = 0;
};

}  // namespace lsmvs::internal
