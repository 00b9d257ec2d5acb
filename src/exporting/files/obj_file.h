#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "lsmvs/mesh/textured_mesh.h"

namespace lsmvs {

// Writes OBJ and, with a texture, an MTL of the same stem beside it. `offset` is subtracted from
// the coordinates. `pages` are where the texture's files lie, beside the OBJ: they are named by
// their base names. Vertices are #V as in the mesh, with colours (0 to 1 after the coordinates, as
// MeshLab writes them) where it has any and no texture. Texture coordinates have v upwards, as all
// readers of OBJ expect. Numbers are the shortest that read back the same in single precision.
// Atomic; the MTL is written first.
void WriteObj(const std::filesystem::path& path, const TexturedMesh& textured,
              const std::vector<std::filesystem::path>& pages, const Eigen::Vector3d& offset);

}  // namespace lsmvs
