#include "lsmvs/merging/seam/seam_labels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Edge lengths that the other surface must go on beyond a border for that not to be its border.
constexpr double kContinues = 2.5;
// Patches without a match up to this many vertices say nothing.
constexpr size_t kMaxUnclearVertices = 60;
// Share of the rim of a patch that must lie over the inside of the other surface.
constexpr double kConflictRim = 0.7;
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

std::vector<double> FromVertices(const BandSurface& surface, const std::vector<uint8_t>& starts,
                                 double max_edges, std::vector<int32_t>* nearest = nullptr) {
  std::vector<double> start(starts.size(), kInfinity);
  double longest = 0;
  for (size_t v = 0; v < starts.size(); ++v) {
    longest = std::max(longest, surface.frames.edge_length[v]);
    if (starts[v]) start[v] = 0;
  }
  return DistanceAlongEdges(surface.mesh(), surface.topology, std::move(start), max_edges * longest,
                            nearest);
}

// Connected patches of the vertices that have no match.
struct Patches {
  Patches(const OverlapSide& side, const OverlapSide& other)
      : sets(side.states.size()),
        size(side.states.size(), 0),
        rim(size),
        inner_rim(size),
        is_open(side.states.size(), 0) {
    const auto is_alone = [&](size_t v) { return side.states[v] != VertexState::kOver; };
    const auto& topology = side.surface->topology;
    for (size_t v = 0; v < size.size(); ++v) {
      if (!is_alone(v)) continue;
      topology.ForNeighbors(static_cast<int32_t>(v), [&](int32_t w) {
        if (is_alone(Index(w))) sets.Unite(static_cast<uint32_t>(v), static_cast<uint32_t>(w));
      });
    }
    for (size_t v = 0; v < size.size(); ++v) {
      if (!is_alone(v)) continue;
      const uint32_t patch = sets.Find(static_cast<uint32_t>(v));
      ++size[patch];
      // The band ends here, or the other surface does.
      if (side.surface->band->is_fixed[v] || side.matches[v].at_border) is_open[patch] = 1;
      topology.ForNeighbors(static_cast<int32_t>(v), [&](int32_t w) {
        if (is_alone(Index(w))) return;
        ++rim[patch];
        const double distance =
            OverlapSide::AtMatch(other, other.from_border, side.matches[Index(w)]);
        inner_rim[patch] += distance > kContinues * side.CoarserEdge(other, Index(w));
      });
    }
  }

  DisjointSets sets;
  std::vector<size_t> size, rim, inner_rim;
  std::vector<uint8_t> is_open;
};

}  // namespace

OverlapSide::OverlapSide(const BandSurface& s, const BandSurface& other, double max_edges,
                         const RunContext& context)
    : surface(&s), matches(MatchVertices(s, other, max_edges, context)) {
  std::vector<uint8_t> on_border(matches.size());
  for (size_t v = 0; v < matches.size(); ++v) {
    on_border[v] = s.topology.IsOnBorder(static_cast<int32_t>(v));
  }
  from_border = FromVertices(s, on_border, 8);
  states.resize(matches.size());
  for (size_t v = 0; v < matches.size(); ++v) {
    states[v] = VertexState::kBeside;
    if (matches[v].face < 0) continue;
    const double edge = std::max(s.frames.edge_length[v], other.EdgeLengthAt(matches[v].face));
    if (!matches[v].at_border) {
      states[v] = VertexState::kOver;
    } else if (matches[v].distance <= kContinues * edge) {
      states[v] = VertexState::kAtRim;
    }
  }
}

double OverlapSide::CoarserEdge(const OverlapSide& other, size_t v) const {
  const double own = surface->frames.edge_length[v];
  const int32_t face = matches[v].face;
  return face < 0 ? own : std::max(own, other.surface->EdgeLengthAt(face));
}

double OverlapSide::AtMatch(const OverlapSide& other, const std::vector<double>& distance,
                            const SurfaceMatch& match) {
  double least = kInfinity;
  if (match.face < 0) return least;
  for (const int v : other.surface->mesh().faces[Index(match.face)]) {
    const double way = (other.surface->mesh().vertices[Index(v)] - match.point).norm();
    least = std::min(least, distance[Index(v)] + way);
  }
  return least;
}

void OverlapSide::Classify(const OverlapSide& other, double inset, double max_edges,
                           const RunContext& context) {
  Patches patches(*this, other);
  const std::vector<uint8_t> is_end =
      FindEnds(*surface, matches, *other.surface, kContinues, max_edges, context);
  std::vector<uint8_t> in_conflict(matches.size(), 0);
  for (size_t v = 0; v < matches.size(); ++v) {
    if (states[v] == VertexState::kOver || states[v] == VertexState::kAtRim) continue;
    if (!in_free_space.empty() && in_free_space[v]) {
      states[v] = VertexState::kConflict;
      in_conflict[v] = 1;
      continue;
    }
    const uint32_t patch = patches.sets.Find(static_cast<uint32_t>(v));
    const double rim = static_cast<double>(patches.rim[patch]);
    if (patches.is_open[patch] || rim == 0 ||
        static_cast<double>(patches.inner_rim[patch]) < kConflictRim * rim) {
      continue;
    }
    const bool is_small = patches.size[patch] <= kMaxUnclearVertices;
    states[v] = is_small ? VertexState::kUnclear : VertexState::kConflict;
    in_conflict[v] = !is_small;
  }
  from_end = FromVertices(*surface, is_end, kInfinity);
  from_conflict = FromVertices(*surface, in_conflict, std::max(inset, max_edges + kConflictReach),
                               &nearest_conflict);
  first_wins.assign(matches.size(), 1);
  for (const Eigen::Vector3i& face : surface->mesh().faces) {
    num_conflict_faces +=
        in_conflict[Index(face[0])] && in_conflict[Index(face[1])] && in_conflict[Index(face[2])];
  }
}

namespace {

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

namespace {

class RimSmoother {
 public:
  RimSmoother(const MeshBand& band, std::vector<uint8_t>* kept)
      : band_(band),
        kept_(*kept),
        neighbors_(FindFaceNeighbors(band.mesh.faces, band.mesh.vertices.size())) {}

  void Run(size_t min_num_faces) {
    bool is_changed = true;
    while (is_changed) {
      is_changed = DropTeeth();
      is_changed |= DropTouchingFans();
    }
    DropSmallPieces(min_num_faces);
  }

 private:
  // Sides of a face across which a face was taken out.
  int NumRimSides(size_t f) const {
    int count = 0;
    for (const int32_t other : neighbors_[f]) count += other >= 0 && !kept_[Index(other)];
    return count;
  }

  bool IsFixed(size_t f) const {
    const Eigen::Vector3i& face = band_.mesh.faces[f];
    return std::any_of(face.begin(), face.end(),
                       [&](int v) { return band_.is_fixed[Index(v)] != 0; });
  }

  bool DropTeeth() {
    std::vector<size_t> teeth;
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (kept_[f] && NumRimSides(f) >= 2 && !IsFixed(f)) teeth.push_back(f);
    }
    for (const size_t f : teeth) kept_[f] = 0;
    return !teeth.empty();
  }

  // Kept faces must form one fan at each vertex, unless they did not before.
  bool DropTouchingFans() {
    const size_t num_vertices = band_.mesh.vertices.size();
    std::vector<uint8_t> on_rim(num_vertices, 0);
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f] || NumRimSides(f) == 0) continue;
      for (int k = 0; k < 3; ++k) {
        const int32_t other = neighbors_[f][Index(k)];
        if (other < 0 || kept_[Index(other)]) continue;
        on_rim[Index(band_.mesh.faces[f][k])] = on_rim[Index(band_.mesh.faces[f][(k + 1) % 3])] = 1;
      }
    }
    // Corners that are joined across kept edges.
    DisjointSets fans(3 * kept_.size());
    const auto corner_of = [&](size_t f, int v) {
      const Eigen::Vector3i& face = band_.mesh.faces[f];
      return static_cast<uint32_t>(3 * f + (face[0] == v ? 0 : face[1] == v ? 1 : 2));
    };
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f]) continue;
      for (int k = 0; k < 3; ++k) {
        const int32_t other = neighbors_[f][Index(k)];
        if (other < 0 || !kept_[Index(other)]) continue;
        for (const int v : {band_.mesh.faces[f][k], band_.mesh.faces[f][(k + 1) % 3]}) {
          if (on_rim[Index(v)]) fans.Unite(corner_of(f, v), corner_of(Index(other), v));
        }
      }
    }
    std::vector<uint32_t> first_fan(num_vertices, 0xFFFFFFFFu);
    std::vector<uint8_t> is_touching(num_vertices, 0);
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f]) continue;
      for (int k = 0; k < 3; ++k) {
        const size_t v = Index(band_.mesh.faces[f][k]);
        if (!on_rim[v]) continue;
        const uint32_t fan = fans.Find(static_cast<uint32_t>(3 * f + Index(k)));
        if (first_fan[v] == 0xFFFFFFFFu) first_fan[v] = fan;
        is_touching[v] |= first_fan[v] != fan;
      }
    }
    bool is_changed = false;
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f] || IsFixed(f)) continue;
      const Eigen::Vector3i& face = band_.mesh.faces[f];
      if (std::any_of(face.begin(), face.end(),
                      [&](int v) { return is_touching[Index(v)] != 0; })) {
        kept_[f] = 0;
        is_changed = true;
      }
    }
    return is_changed;
  }

  void DropSmallPieces(size_t min_num_faces) {
    DisjointSets pieces(kept_.size());
    for (size_t f = 0; f < kept_.size(); ++f) {
      for (const int32_t other : neighbors_[f]) {
        if (kept_[f] && other >= 0 && kept_[Index(other)]) {
          pieces.Unite(static_cast<uint32_t>(f), static_cast<uint32_t>(other));
        }
      }
    }
    std::vector<size_t> size(kept_.size(), 0);
    std::vector<uint8_t> has_rim(kept_.size(), 0), is_anchored(kept_.size(), 0);
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f]) continue;
      const uint32_t piece = pieces.Find(static_cast<uint32_t>(f));
      ++size[piece];
      has_rim[piece] |= NumRimSides(f) > 0;
      is_anchored[piece] |= IsFixed(f);
    }
    for (size_t f = 0; f < kept_.size(); ++f) {
      const uint32_t piece = pieces.Find(static_cast<uint32_t>(f));
      if (has_rim[piece] && !is_anchored[piece] && size[piece] < min_num_faces) kept_[f] = 0;
    }
  }

  const MeshBand& band_;
  std::vector<uint8_t>& kept_;
  FaceNeighbors neighbors_;
};

}  // namespace

void SmoothRim(const MeshBand& band, size_t min_num_faces, std::vector<uint8_t>* kept) {
  RimSmoother(band, kept).Run(min_num_faces);
}

}  // namespace lsmvs
