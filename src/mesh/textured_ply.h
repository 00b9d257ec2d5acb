#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/mesh/textured_mesh.h"

namespace lsmvs {

// Textured meshes as COLMAP's mesh_texturer, MeshLab and OpenMVS write them: `comment TextureFile
// NAME` once per page, per face `list uchar float texcoord` with u and v of each corner, and `int
// texnumber` where there are several pages. u, v are in [0, 1] of the page, v from its bottom up
// (MeshLab, COLMAP, Open3D and trimesh agree).

// Reads any of them, also with u, v (or s, t or texture_u, texture_v) per vertex; a PLY without
// texture gives a mesh without pages. Polygons become fans. Page files are looked for beside the
// mesh: by their name with its folders, then by their base name. Of the pages only the headers are
// read. page_width and page_height are the largest of them. `world_offset` is subtracted from every
// vertex. Throws InputError as ReadMeshPly does, and if a page is missing or no image.
TexturedMesh ReadTexturedPly(const std::filesystem::path& path,
                             const Eigen::Vector3d& world_offset = Eigen::Vector3d::Zero(),
                             NotFinite not_finite = NotFinite::kRefuse);

// Writes binary little-endian PLY as WriteMeshPly does, plus the texture. Pages are named by their
// base names: the caller puts their files beside the mesh. Texture coordinates come back to within
// 1e-7 of the page's size. Atomic.
void WriteTexturedPly(const std::filesystem::path& path, const TexturedMesh& textured,
                      const Eigen::Vector3d& world_offset = Eigen::Vector3d::Zero());

}  // namespace lsmvs
