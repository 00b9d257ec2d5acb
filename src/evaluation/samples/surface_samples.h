#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// `count` points on the mesh, independent and uniform over its area, or, of a mesh without faces,
// `count` different vertices (all of them if there are fewer). Faces and vertices that are not
// finite get none. The same seed gives the same points for any number of threads. Empty if the area
// is 0.
std::vector<Eigen::Vector3d> SampleSurface(const TriangleMesh& mesh, size_t count, uint64_t seed,
                                           const RunContext& context);

// One point, drawn at random, of each voxel that holds any; points that are not finite are left
// out. A cloud is denser where photos are close: so thinned, its points are about uniform over its
// area. The same seed gives the same points. O(n log n).
std::vector<Eigen::Vector3d> OnePointPerVoxel(const std::vector<Eigen::Vector3d>& points,
                                              double voxel_size, uint64_t seed);

}  // namespace lsmvs
