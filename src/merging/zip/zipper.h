#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Two surfaces as one mesh, with a gap of about an edge length between their rims.
struct ZipProblem {
  const TriangleMesh* mesh = nullptr;   // manifold
  std::vector<uint8_t> side;            // #V: 0 or 1, the surface of a vertex
  std::vector<double> edge_length;      // #V
  std::vector<Eigen::Vector3d> normal;  // #V, unit length
  std::vector<uint64_t> old_border;     // edges (EdgeKey) that were border before; ascending
  std::vector<uint64_t> cut_edges;      // edges at which faces lie that are not in the mesh
};

struct ZipResult {
  std::vector<Eigen::Vector3i> faces;  // to be added: with them the mesh is manifold and oriented
  // Edges of new rims that stay border, in the direction of their faces.
  std::vector<std::array<int32_t, 2>> open_edges;
};

// Fills the gap between the rims with triangles between their vertices. Vertices of either rim that
// are nearest to each other are joined, in the order in which they follow each other on both rims;
// the polygons between two such bridges are triangulated at least cost. What is left over of
// closed gaps without partner is filled if it is small; what lies farther apart than some edge
// lengths stays open. Adds no vertices. O(r log r) for rims of r vertices.
ZipResult ZipRims(const ZipProblem& problem);

}  // namespace lsmvs
