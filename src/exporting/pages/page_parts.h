#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/textured_mesh.h"

namespace lsmvs {

// The faces of one page with vertices as graphics cards want them: a place with one pair of texture
// coordinates.
struct PagePart {
  int page = -1;                    // -1: without texture
  std::vector<int> vertices;        // #v, of the mesh
  std::vector<Eigen::Vector2f> uv;  // #v, in [0, 1] of the page, y down; empty without texture
  std::vector<Eigen::Vector3i> faces;
};

// Parts in the order of their pages, without those that no face uses; one part without texture.
// Vertices in the order in which faces first use them. O(#F + #pages).
std::vector<PagePart> SplitByPage(const TexturedMesh& textured);

}  // namespace lsmvs
