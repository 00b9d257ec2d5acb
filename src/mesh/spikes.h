#pragma once

#include <cstddef>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Sinks spikes: single vertices that stand out of a surface and have no other near by, such as
// false points that a cut took along. A spike is farther from the middle of its neighbours than 1.5
// times their mean distance from there, and no neighbour is nearer than `least_edges[v]` (#V); it
// goes to that middle. What stands behind it comes next, six times at most. Vertices on borders
// stay, and so do spikes that would make the surface pass through itself (UndoCollisions). Returns
// the number of vertices that moved. O(#V + #F); nothing but that if there is no spike.
size_t SinkSpikes(const std::vector<double>& least_edges, const RunContext& context,
                  TriangleMesh* mesh);

}  // namespace lsmvs
