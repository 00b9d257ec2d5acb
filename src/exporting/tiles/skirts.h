#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/exporting/tiles/tile_mesh.h"

namespace lsmvs {

// Adds strips of faces of the given width under the border edges between locked vertices, where
// other tiles join. They lead inwards and a little outwards and show the border's texels: what a
// viewer's rounding leaves open between two tiles then shows colour and not the background.
// `is_locked` and `normals` (unit length, outward) are of the vertices of the finest mesh.
// O(#F of the tile).
void AddSkirts(const std::vector<uint8_t>& is_locked, const std::vector<Eigen::Vector3f>& normals,
               double width, TileMesh* tile);

}  // namespace lsmvs
