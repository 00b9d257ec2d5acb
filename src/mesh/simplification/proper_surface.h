#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/mesh/simplify.h"
#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs::internal {

// The vertices and faces of a mesh that can be worked on, near the origin, and where they come
// from.
struct ProperSurface {
  std::vector<Eigen::Vector3d> vertices;  // minus the origin: quadrics lose digits far from it
  std::vector<Eigen::Vector3i> faces;
  std::vector<int> source;  // of each vertex, in the mesh
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
};

// Without faces that name a vertex twice or are not finite, and without unused vertices; vertices
// come in the order in which faces first use them.
ProperSurface ProperPart(const TriangleMesh& mesh);

// The mesh of a surface's used vertices, in the order in which faces first use them; `positions` in
// the world.
SimplifiedMesh CompactMesh(const std::vector<Eigen::Vector3d>& positions,
                           const std::vector<Eigen::Vector3i>& faces,
                           const std::vector<int>& source);

}  // namespace lsmvs::internal
