#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

struct SurfaceOctreeNode {
  int parent = -1;
  int depth = 0;              // of the root 0; nodes with a single child are left out
  std::vector<int> children;  // nodes, after their parent; empty in leaves
  std::vector<int> faces;     // of leaves: those whose centroids lie in the cell
  std::string name;           // "r", then the octant of each level
};

// Divides the faces of a mesh by their centroids: cells are halved along all axes until a leaf has
// at most `max_faces` faces and their weights sum to at most `max_weight`. Cells that cannot be
// divided any more (all centroids in one place) stay larger. The root is node 0 and each face in
// one leaf. `weights` is #F or empty. O(F log F).
std::vector<SurfaceOctreeNode> BuildSurfaceOctree(const TriangleMesh& mesh,
                                                  const std::vector<double>& weights,
                                                  size_t max_faces, double max_weight);

// For each vertex the deepest node whose cells hold all its faces; -1 for unused ones. O(F).
std::vector<int> NodesOfVertices(const TriangleMesh& mesh,
                                 const std::vector<SurfaceOctreeNode>& nodes);

}  // namespace lsmvs
