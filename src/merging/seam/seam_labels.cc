#include "lsmvs/merging/seam/seam_labels.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

namespace {

constexpr double kCapacityPerEdge = 1000;
// Costs of a seam: per edge length of it, and for each edge length between the surfaces.
constexpr double kLengthCost = 0.3, kDistanceCost = 1.0, kMaxDistance = 6;
constexpr double kPreferenceGain = 2, kResolutionGain = 0.25, kEqualResolution = 0.25,
                 kMaxResolution = 2;
// Of the surface whose end is farther away; distances count up to so many edge lengths.
constexpr double kEndGain = 0.02, kEndReach = 12;
// Edge lengths from midway between the ends within which the seam of alike meshes is looked for.
constexpr double kCorridor = 150;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

// Builds and cuts the graph of the first surface's faces.
class FirstLabeler {
 public:
  FirstLabeler(const OverlapSide& first, const OverlapSide& second, const SeamOptions& options)
      : first_(first), second_(second), options_(options), mesh_(first.surface->mesh()) {}

  std::vector<uint8_t> Run(const RunContext& context) {
    std::vector<CutNode> nodes(mesh_.faces.size());
    for (size_t f = 0; f < nodes.size(); ++f) nodes[f].excess = Excess(f);
    const std::vector<HalfEdge> sides = SortedHalfEdges(mesh_.faces, mesh_.vertices.size());
    ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
      if (end - begin != 2 || begin[0].face == begin[1].face) return;
      for (int k = 0; k < 2; ++k) {
        const HalfEdge &here = begin[k], &there = begin[1 - k];
        CutNode& node = nodes[Index(here.face)];
        node.neighbor[Index(here.corner)] = there.face;
        node.capacity[Index(here.corner)] = EdgeCapacity(Index(here.low), Index(here.high));
        node.SetReverse(here.corner, there.corner);
      }
    });
    MaximizeFlow(&nodes, context);
    std::vector<uint8_t> labels(nodes.size());
    for (size_t f = 0; f < nodes.size(); ++f) labels[f] = nodes[f].OnSourceSide();
    return labels;
  }

 private:
  // +1: must stay; -1: must go; 0: either.
  int Demand(size_t v) const {
    switch (first_.states[v]) {
      case VertexState::kBeside:
        return 1;
      case VertexState::kConflict:
        return first_.first_wins[v] ? 1 : -1;
      case VertexState::kUnclear:
        return 0;
      case VertexState::kAtRim:
      case VertexState::kOver:
        break;
    }
    const double inset = options_.inset * first_.CoarserEdge(second_, v);
    const auto& match = first_.matches[v];
    if (const int winner = WinnerNearby(v, inset); winner != 0) return winner;
    const double to_end = first_.from_end[v];
    const double to_second_end = OverlapSide::AtMatch(second_, second_.from_end, match);
    if (to_second_end < inset && to_second_end < to_end) return 1;
    if (to_end < inset) return -1;
    return IsAlike(v) ? FarFromMidway(v, to_end - to_second_end) : 0;
  }

  // Whether neither surface is preferred at v.
  bool IsAlike(size_t v) const {
    const SurfaceMatch& match = first_.matches[v];
    if (match.face < 0 || first_.surface->band->is_preferred[v]) return false;
    return std::abs(std::log2(second_.surface->EdgeLengthAt(match.face) /
                              first_.surface->frames.edge_length[v])) < kEqualResolution;
  }

  // In wide overlaps the flow stays small, and surfaces get worse towards their ends.
  int FarFromMidway(size_t v, double farther) const {
    const double reach = kCorridor * first_.CoarserEdge(second_, v);
    return farther > reach ? 1 : farther < -reach ? -1 : 0;
  }

  // Of a conflict of either surface within `reach`: +1: the first; -1: the second; 0: there is
  // none.
  int WinnerNearby(size_t v, double reach) const {
    const auto& match = first_.matches[v];
    double least = first_.from_conflict[v];
    bool first_wins = first_.first_wins[v] != 0;
    if (match.face >= 0) {
      for (const int w : second_.surface->mesh().faces[Index(match.face)]) {
        const double distance = second_.from_conflict[Index(w)] +
                                (second_.surface->mesh().vertices[Index(w)] - match.point).norm();
        if (distance >= least) continue;
        least = distance;
        first_wins = second_.first_wins[Index(w)] != 0;
      }
    }
    if (!(least < reach)) return 0;
    return first_wins ? 1 : -1;
  }

  int32_t Excess(size_t f) const {
    int stay = 0, go = 0;
    for (const int v : mesh_.faces[f]) {
      const int demand = Demand(Index(v));
      stay += demand > 0;
      go += demand < 0;
    }
    if (stay > go) return CutNode::kMaxCapacity;
    if (go > stay) return -CutNode::kMaxCapacity;
    return static_cast<int32_t>(std::lround(kCapacityPerEdge * Gain(f)));
  }

  double Gain(size_t f) const {
    double own = 0, other = 0;
    for (const int v : mesh_.faces[f]) {
      const SurfaceMatch& match = first_.matches[Index(v)];
      if (match.face < 0) continue;
      own += first_.surface->frames.edge_length[Index(v)];
      other += second_.surface->EdgeLengthAt(match.face);
    }
    if (own == 0) return 0;
    if (IsPreferred(f)) return kPreferenceGain;
    const double finer = std::log2(other / own);
    if (std::abs(finer) < kEqualResolution) return EndGain(f);
    return kResolutionGain * std::clamp(finer, -kMaxResolution, kMaxResolution);
  }

  // Surfaces get worse towards their ends: where nothing else tells, the seam runs midway.
  double EndGain(size_t f) const {
    double sum = 0;
    for (const int v : mesh_.faces[f]) {
      const double reach = kEndReach * first_.CoarserEdge(second_, Index(v));
      const auto share = [&](double distance) { return std::min(distance / reach, 1.0); };
      sum += share(first_.from_end[Index(v)]) -
             share(OverlapSide::AtMatch(second_, second_.from_end, first_.matches[Index(v)]));
    }
    return kEndGain * sum / 3;
  }

  bool IsPreferred(size_t f) const {
    const Eigen::Vector3i& face = mesh_.faces[f];
    const auto& is_preferred = first_.surface->band->is_preferred;
    return std::all_of(face.begin(), face.end(),
                       [&](int v) { return is_preferred[Index(v)] != 0; });
  }

  int32_t EdgeCapacity(size_t a, size_t b) const {
    const double edge = 0.5 * (first_.CoarserEdge(second_, a) + first_.CoarserEdge(second_, b));
    const auto apart = [&](size_t v) {
      const bool has_match = first_.matches[v].face >= 0;
      return has_match ? std::min(first_.matches[v].distance / edge, kMaxDistance) : kMaxDistance;
    };
    const double length = (mesh_.vertices[a] - mesh_.vertices[b]).norm();
    const double own =
        0.5 * (first_.surface->frames.edge_length[a] + first_.surface->frames.edge_length[b]);
    const double cost = kLengthCost + kDistanceCost * 0.5 * (apart(a) + apart(b));
    return 1 + static_cast<int32_t>(
                   std::lround(kCapacityPerEdge * std::min(length / own, 100.0) * cost));
  }

  const OverlapSide& first_;
  const OverlapSide& second_;
  const SeamOptions& options_;
  const TriangleMesh& mesh_;
};

// Edges between faces that stay and faces that go, as degenerate triangles.
std::vector<Eigen::Vector3i> SeamEdges(const TriangleMesh& mesh,
                                       const std::vector<uint8_t>& labels) {
  std::vector<Eigen::Vector3i> edges;
  const std::vector<HalfEdge> sides = SortedHalfEdges(mesh.faces, mesh.vertices.size());
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    if (end - begin == 2 && labels[Index(begin[0].face)] != labels[Index(begin[1].face)]) {
      edges.emplace_back(begin->low, begin->high, begin->high);
    }
  });
  return edges;
}

}  // namespace

std::vector<uint8_t> LabelFirstSurface(const OverlapSide& first, const OverlapSide& second,
                                       const SeamOptions& options, const RunContext& context) {
  return FirstLabeler(first, second, options).Run(context);
}

std::vector<uint8_t> LabelSecondSurface(const OverlapSide& first, const OverlapSide& second,
                                        const std::vector<uint8_t>& first_labels, double clearance,
                                        const RunContext& context) {
  constexpr uint8_t kGo = 0, kStay = 1, kUnknown = 2;
  const TriangleMesh& mesh = second.surface->mesh();
  const std::vector<Eigen::Vector3i> seam = SeamEdges(first.surface->mesh(), first_labels);
  const SurfaceIndex seam_index(first.surface->mesh().vertices, seam);
  std::vector<uint8_t> stays(mesh.vertices.size());
  ParallelFor(context, stays.size(), 1 << 10, [&](size_t v) {
    const SurfaceMatch& match = second.matches[v];
    switch (second.states[v]) {
      case VertexState::kBeside:
        stays[v] = kStay;
        return;
      case VertexState::kUnclear:
        stays[v] = kUnknown;
        return;
      case VertexState::kConflict:
        stays[v] = second.first_wins[v] ? kGo : kStay;
        return;
      default:
        break;
    }
    const double edge = second.surface->frames.edge_length[v];
    stays[v] = !first_labels[Index(match.face)] &&
               seam_index.Closest(match.point, clearance * edge).face < 0;
  });
  // Unclear vertices follow what is around them, ring by ring.
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    const std::vector<uint8_t> before = stays;
    for (size_t v = 0; v < stays.size(); ++v) {
      if (before[v] != kUnknown) continue;
      int num_stay = 0, num_go = 0;
      second.surface->topology.ForNeighbors(static_cast<int32_t>(v), [&](int32_t w) {
        num_stay += before[Index(w)] == kStay;
        num_go += before[Index(w)] == kGo;
      });
      if (num_stay + num_go == 0) continue;
      stays[v] = num_stay > num_go ? kStay : kGo;
      is_changed = true;
    }
  }
  std::vector<uint8_t> kept(mesh.faces.size());
  for (size_t f = 0; f < kept.size(); ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    kept[f] = stays[Index(face[0])] == kStay && stays[Index(face[1])] == kStay &&
              stays[Index(face[2])] == kStay;
  }
  return kept;
}

}  // namespace lsmvs
