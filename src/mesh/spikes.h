#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Sinks spikes: single vertices that stand out of a surface and have no other near by, such as
// false points that a cut took along. A spike is farther from the middle of its neighbours than 1.5
// times their mean distance from there, and no neighbour is nearer than `least_edges[v]` (#V). It
// goes to that middle. Repeated up to six times, for spikes on spikes. Vertices on borders stay,
// and so do spikes that would make the surface pass through itself. Returns the vertices that
// moved, ascending. O(#V + #F); where there are spikes, also the grid that finds crossings
// (FaceGrid).
std::vector<int32_t> SinkSpikes(const std::vector<double>& least_edges, const RunContext& context,
                                TriangleMesh* mesh);

}  // namespace lsmvs
