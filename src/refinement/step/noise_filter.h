#pragma once

#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Takes noise off a mesh by its normals (FilterNormals) where triangles are so small that photos
// cannot resolve their shape. Edges stay sharp. A vertex moves by its shortest edge at most; where
// that is longer than `max_edge_px` pixels, it stays. `pixel_size`: #V, world units; 0: stays. What
// would make the surface pass through itself is taken back (UndoCollisions). 4 us a face.
void FilterNoise(int num_passes, double max_edge_px, const std::vector<double>& pixel_size,
                 TriangleMesh* mesh, const RunContext& context);

}  // namespace lsmvs
