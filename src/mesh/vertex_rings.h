#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Neighbours of the vertices of a mesh: those of v are neighbors[begin[v] .. begin[v+1]),
// ascending.
struct VertexRings {
  std::vector<int32_t> begin;      // #V + 1
  std::vector<int32_t> neighbors;  // 2 * #E
  std::vector<uint8_t> on_border;  // #V: 1 at edges that do not have exactly two faces
};

// O(#V + #F); 16 bytes per half edge of scratch.
VertexRings BuildVertexRings(const TriangleMesh& mesh);

}  // namespace lsmvs
