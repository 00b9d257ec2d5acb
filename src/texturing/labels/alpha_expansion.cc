#include "lsmvs/texturing/labels/alpha_expansion.h"

#include <algorithm>
#include <atomic>
#include <span>
#include <vector>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/graph/minimum_cut.h"

namespace lsmvs {

namespace {

using Blocks = std::vector<std::span<const uint32_t>>;

std::vector<uint32_t> OrderInSpace(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> middles;
  middles.reserve(mesh.faces.size());
  for (const Eigen::Vector3i& f : mesh.faces) {
    middles.push_back((mesh.vertices[f[0]] + mesh.vertices[f[1]] + mesh.vertices[f[2]]) / 3.0);
  }
  return HilbertOrder(middles);
}

// Blocks of the ordered faces; the first has only `first_size`.
Blocks CutIntoBlocks(const std::vector<uint32_t>& order, size_t first_size, size_t size) {
  Blocks blocks;
  for (size_t begin = 0; begin < order.size();) {
    const size_t end = std::min(order.size(), begin == 0 ? first_size : begin + size);
    blocks.emplace_back(order.data() + begin, end - begin);
    begin = end;
  }
  return blocks;
}

// The block of each face.
std::vector<uint32_t> BlockOfFaces(const Blocks& blocks, size_t num_faces) {
  std::vector<uint32_t> block_of(num_faces);
  for (uint32_t b = 0; b < blocks.size(); ++b) {
    for (const uint32_t f : blocks[b]) block_of[f] = b;
  }
  return block_of;
}

// Groups of blocks none of which touch: greedily, in the order of the blocks.
std::vector<std::vector<uint32_t>> IndependentGroups(const Blocks& blocks,
                                                     const std::vector<uint32_t>& block_of,
                                                     const FaceNeighbors& neighbors) {
  std::vector<std::vector<uint32_t>> groups;
  std::vector<size_t> group_of(blocks.size(), blocks.size());
  for (uint32_t b = 0; b < blocks.size(); ++b) {
    std::vector<bool> taken(groups.size() + 1, false);
    for (const uint32_t f : blocks[b]) {
      for (const int32_t other : neighbors[f]) {
        if (other < 0) continue;
        const size_t group = group_of[block_of[static_cast<size_t>(other)]];
        if (group < taken.size()) taken[group] = true;
      }
    }
    const auto free = std::find(taken.begin(), taken.end(), false);
    const auto group = static_cast<size_t>(free - taken.begin());
    if (group == groups.size()) groups.emplace_back();
    groups[group].push_back(b);
    group_of[b] = group;
  }
  return groups;
}

// Expansion moves in one block; faces outside of it keep their labels.
class BlockExpander {
 public:
  BlockExpander(const LabelEnergy& energy, std::span<const uint32_t> faces, uint32_t block,
                const std::vector<uint32_t>& block_of, std::vector<int32_t>* node_of,
                ViewSlots* slots, const RunContext& context)
      : energy_(energy),
        faces_(faces),
        block_(block),
        block_of_(block_of),
        node_of_(*node_of),
        slots_(*slots),
        context_(context) {}

  // Whether any label has changed.
  bool Run() {
    const std::vector<Choice> choices = SortedChoices();
    bool changed = false;
    for (size_t begin = 0; begin < choices.size();) {
      size_t end = begin;
      while (end < choices.size() && choices[end].view_idx == choices[begin].view_idx) ++end;
      changed |= Expand({choices.data() + begin, end - begin});
      begin = end;
    }
    return changed;
  }

 private:
  // A face may take a view.
  struct Choice {
    int32_t view_idx;
    uint32_t face;
    uint8_t slot;
  };

  std::vector<Choice> SortedChoices() const {
    std::vector<Choice> choices;
    for (const uint32_t f : faces_) {
      const auto of_face = energy_.candidates().Of(f);
      if (of_face.size() < 2) continue;
      for (size_t k = 0; k < of_face.size(); ++k) {
        choices.push_back({of_face[k].view_idx, f, static_cast<uint8_t>(k)});
      }
    }
    std::stable_sort(choices.begin(), choices.end(),
                     [](const Choice& a, const Choice& b) { return a.view_idx < b.view_idx; });
    return choices;
  }

  bool Expand(std::span<const Choice> choices) {
    context_.ThrowIfCancelled();
    const int view_idx = choices.front().view_idx;
    active_.clear();
    for (const Choice& choice : choices) {
      if (energy_.ViewOf(slots_, choice.face) == view_idx) continue;
      node_of_[choice.face] = static_cast<int32_t>(active_.size());
      active_.push_back(choice);
    }
    nodes_.assign(active_.size(), CutNode());
    for (size_t i = 0; i < active_.size(); ++i) AddFace(i, view_idx);
    const bool changed = Cut();
    for (const Choice& choice : active_) node_of_[choice.face] = -1;
    return changed;
  }

  // Nodes on the source's side switch.
  bool Cut() {
    const bool any = std::any_of(nodes_.begin(), nodes_.end(),
                                 [](const CutNode& node) { return node.excess > 0; });
    if (!any) return false;
    MaximizeFlow(&nodes_, context_);
    bool changed = false;
    for (size_t i = 0; i < active_.size(); ++i) {
      if (!nodes_[i].OnSourceSide()) continue;
      slots_[active_[i].face] = active_[i].slot;
      changed = true;
    }
    return changed;
  }

  int32_t NodeOf(size_t face) const { return block_of_[face] == block_ ? node_of_[face] : -1; }

  void AddFace(size_t i, int view_idx) {
    const size_t f = active_[i].face;
    nodes_[i].excess += energy_.FaceCost(f, slots_[f]) - energy_.FaceCost(f, active_[i].slot);
    for (int side = 0; side < 3; ++side) {
      const int32_t neighbor = energy_.neighbors()[f][static_cast<size_t>(side)];
      if (neighbor < 0) continue;
      const auto other = static_cast<size_t>(neighbor);
      const int other_view = energy_.ViewOf(slots_, other);
      if (other_view < 0) continue;
      const int32_t j = NodeOf(other);
      if (j < 0) {
        AddEdgeToFixed(i, side, view_idx, other_view);
      } else if (static_cast<size_t>(j) > i) {
        AddEdge(i, side, static_cast<size_t>(j), view_idx, other_view);
      }
    }
  }

  void AddEdgeToFixed(size_t i, int side, int view_idx, int other_view) {
    const size_t f = active_[i].face;
    nodes_[i].excess += energy_.EdgeCost(f, side, energy_.ViewOf(slots_, f), other_view) -
                        energy_.EdgeCost(f, side, view_idx, other_view);
  }

  // With x = 1 for faces that switch, the edge costs kept + (first_switches - kept) x_i -
  // first_switches x_j + (first_switches + second_switches - kept) (1 - x_i) x_j.
  void AddEdge(size_t i, int side, size_t j, int view_idx, int other_view) {
    const size_t f = active_[i].face;
    const int view = energy_.ViewOf(slots_, f);
    const int32_t kept = energy_.EdgeCost(f, side, view, other_view);
    const int32_t first_switches = energy_.EdgeCost(f, side, view_idx, other_view);
    const int32_t second_switches = energy_.EdgeCost(f, side, view, view_idx);
    const int other_side = SideTo(active_[j].face, f, side);
    CutNode& a = nodes_[i];
    CutNode& b = nodes_[j];
    a.excess -= first_switches - kept;
    b.excess += first_switches;
    a.neighbor[static_cast<size_t>(side)] = static_cast<int32_t>(j);
    b.neighbor[static_cast<size_t>(other_side)] = static_cast<int32_t>(i);
    a.SetReverse(side, other_side);
    b.SetReverse(other_side, side);
    b.capacity[static_cast<size_t>(other_side)] = first_switches + second_switches - kept;
  }

  // The side of `face` that is edge `other_side` of its neighbour `other`.
  int SideTo(size_t face, size_t other, int other_side) const {
    const Eigen::Vector3i& f = energy_.mesh().faces[face];
    const Eigen::Vector3i& g = energy_.mesh().faces[other];
    const int u = g[other_side], v = g[(other_side + 1) % 3];
    for (int k = 0; k < 3; ++k) {
      if (energy_.neighbors()[face][static_cast<size_t>(k)] != static_cast<int32_t>(other))
        continue;
      const int a = f[k], b = f[(k + 1) % 3];
      if ((a == u && b == v) || (a == v && b == u)) return k;
    }
    return 0;
  }

  const LabelEnergy& energy_;
  std::span<const uint32_t> faces_;
  uint32_t block_;
  const std::vector<uint32_t>& block_of_;
  std::vector<int32_t>& node_of_;  // -1 between moves; of this block's faces
  ViewSlots& slots_;
  const RunContext& context_;
  std::vector<Choice> active_;
  std::vector<CutNode> nodes_;
};

}  // namespace

void ExpandLabels(const LabelEnergy& energy, const ExpansionOptions& options, ViewSlots* slots,
                  const RunContext& context) {
  const size_t num_faces = energy.mesh().faces.size();
  const std::vector<uint32_t> order = OrderInSpace(energy.mesh());
  std::vector<int32_t> node_of(num_faces, -1);
  for (int cycle = 0; cycle < options.num_cycles; ++cycle) {
    const size_t size = options.faces_per_block;
    const Blocks blocks = CutIntoBlocks(order, cycle % 2 == 0 ? size : (size + 1) / 2, size);
    const std::vector<uint32_t> block_of = BlockOfFaces(blocks, num_faces);
    std::atomic<bool> changed = false;
    for (const auto& group : IndependentGroups(blocks, block_of, energy.neighbors())) {
      ParallelFor(context, group.size(), 1, [&](size_t i) {
        const uint32_t b = group[i];
        BlockExpander expander(energy, blocks[b], b, block_of, &node_of, slots, context);
        if (expander.Run()) changed = true;
      });
    }
    context.Report(static_cast<double>(cycle + 1) / options.num_cycles);
    if (!changed) break;
  }
}

}  // namespace lsmvs
