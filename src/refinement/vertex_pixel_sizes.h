#pragma once

#include <vector>

#include "lsmvs/geometry/posed_camera.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Of each vertex (#V) what one pixel covers there, in units of the world: depth over focal length
// in the view that sees it finest, of those that it faces and that have it in the picture; without
// such a view of those that have it in the picture; or else of those that it lies before. What is
// in the way does not count, so that sizes are rather too small. Vertices behind all cameras take
// the smallest size of all, and 0 without views. O(#V #views).
std::vector<double> VertexPixelSizes(const TriangleMesh& mesh,
                                     const std::vector<PosedCamera>& views,
                                     const RunContext& context);

}  // namespace lsmvs
