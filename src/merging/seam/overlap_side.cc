#include "lsmvs/merging/seam/overlap_side.h"

#include <algorithm>
#include <limits>

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

}  // namespace lsmvs
