#pragma once

#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Takes noise off a mesh by its normals (FilterNormals) where triangles are smaller than the
// windows by which photos are compared: shape of that size is nothing that photos can tell. Edges
// stay sharp. A vertex moves by its shortest edge at most; where that is longer than 3.5 pixels it
// stays. `pixel_size`: #V, world units; 0: stays. What would make the surface pass through itself
// is taken back (UndoCollisions). O(F log F); 4 us a face.
void FilterNoise(int num_passes, const std::vector<double>& pixel_size, TriangleMesh* mesh,
                 const RunContext& context);

}  // namespace lsmvs
