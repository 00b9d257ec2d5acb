#pragma once

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Mean length of the edges of the faces; 0 without faces.
double MeanEdgeLength(const TriangleMesh& mesh);

}  // namespace lsmvs
