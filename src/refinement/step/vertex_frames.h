#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/photo/pair_selection.h"

namespace lsmvs {

// #V: unit normals of the vertices by the area of their faces, along which they are displaced; (0,
// 0, 1) where there is none.
std::vector<Eigen::Vector3d> VertexDirections(const TriangleMesh& mesh);

// #V: length in the world of one pixel at the vertices: mean over the faces that are seen, the
// median of all where none is; 0 if none is at all.
std::vector<double> MeanPixelSizes(const TriangleMesh& mesh, const FacePairs& pairs);

}  // namespace lsmvs
