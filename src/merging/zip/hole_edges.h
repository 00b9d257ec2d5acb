#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

// An edge of a mesh's border, as a new face at it runs, and the face that is there.
struct HoleEdge {
  int32_t from, to, face;
};

// All of them, sorted by (from, to). O(#F + #V).
std::vector<HoleEdge> FindHoleEdges(std::span<const Eigen::Vector3i> faces, size_t num_vertices);

// The successor of each edge around its hole. Where several holes meet at a vertex, an edge of one
// fan of faces is followed by one of the next fan. `edges` as FindHoleEdges returns them.
std::vector<size_t> HoleSuccessors(std::span<const Eigen::Vector3i> faces,
                                   const std::vector<HoleEdge>& edges);

}  // namespace lsmvs
