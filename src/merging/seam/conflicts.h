#pragma once

#include <functional>

#include "lsmvs/merging/seam/overlap_side.h"

namespace lsmvs {

// What a vertex counts in a conflict: more is better.
using ConflictWorth = std::function<double(const VertexSource& source, double edge_length)>;

// Decides which surface is right in each conflict. A conflict is a patch of vertices in conflict on
// either surface, with those on the other that lie within its rim; the surface whose vertices there
// are worth more in the mean wins it whole. A surface without vertices in conflict there counts by
// what lies around the patch, or, against a piece of its own, as a whole. Ties, and an empty
// `worth`, favour the first. Both sides must have been classified; sets first_wins of both. O(#V
// log #F).
void DecideConflicts(const ConflictWorth& worth, double max_edges, OverlapSide* first,
                     OverlapSide* second);

}  // namespace lsmvs
