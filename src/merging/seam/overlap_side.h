#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/merging/overlap/overlap.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Edge lengths, beyond those of a match, within which patches of both surfaces are one conflict.
inline constexpr double kConflictReach = 3;

// How a vertex lies to the other surface.
enum class VertexState : uint8_t {
  kOver,      // the other surface is there, too
  kAtRim,     // by the border of the other: both end here, or nearly
  kBeside,    // beyond the border of the other, or far from it: only this surface is there
  kUnclear,   // in a small patch for which no match was found
  kConflict,  // in a patch that parts from the other surface where that goes on, or in free space
};

// A surface, its matches on the other, and what follows from them.
struct OverlapSide {
  OverlapSide(const BandSurface& surface, const BandSurface& other, double max_edges,
              const RunContext& context);

  const BandSurface* surface;
  std::vector<SurfaceMatch> matches;  // #V
  std::vector<double> from_border;    // #V: distance along the surface from any border of it
  std::vector<VertexState> states;    // #V
  std::vector<double> from_end;       // #V: from border over which the other surface goes on
  std::vector<double> from_conflict;  // #V: from vertices in conflict
  // #V: the vertex in conflict that is nearest, as far as distances are looked at; else -1.
  std::vector<int32_t> nearest_conflict;
  // #V: whether the first of both surfaces wins the conflict that is nearest; see
  // DecideConflicts().
  std::vector<uint8_t> first_wins;
  // #V, or empty: vertices that stand in space that the other mesh's views saw empty; to be set
  // before Classify().
  std::vector<uint8_t> in_free_space;
  size_t num_conflict_faces = 0;

  // Both sides must have been made. `inset` edge lengths is as far as distances are looked at.
  void Classify(const OverlapSide& other, double inset, double max_edges,
                const RunContext& context);
  // Edge length at v, or of the other surface at its match if that is longer.
  double CoarserEdge(const OverlapSide& other, size_t v) const;
  // A distance of the other side's vertices at the match of v.
  static double AtMatch(const OverlapSide& other, const std::vector<double>& distance,
                        const SurfaceMatch& match);
};

}  // namespace lsmvs
