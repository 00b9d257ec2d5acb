#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// New faces in the place of others, without new vertices.
struct Refilling {
  std::vector<uint8_t> is_dropped;     // #F
  std::vector<Eigen::Vector3i> faces;  // to be added
};

// Replaces patches of faces that cross others: the faces themselves, then with one to three rings
// around them. The hole of a patch is triangulated anew by FillPolygon (`normals`: #V, unit
// length); borders of the mesh stay, and no edge is made between two vertices that are not
// `is_free` (#V). The new patch is taken if none of its faces crosses another one. Crossings count
// where one of both faces `is_active` (#F). O(#F), and the patches.
Refilling RefillCrossings(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> normals,
                          const std::vector<uint8_t>& is_free,
                          const std::vector<uint8_t>& is_active, const RunContext& context);

}  // namespace lsmvs
