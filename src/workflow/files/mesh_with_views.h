#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// A mesh, and the views of its vertices in the file beside it: MESH.vis.

// Both paths.
std::vector<std::filesystem::path> MeshWithViewsFiles(const std::filesystem::path& mesh_path);

// Nothing if there is no such file.
std::optional<PointViews> ReadViewsOf(const std::filesystem::path& mesh_path, size_t num_vertices);

// Without `views` a file of views that lies there is removed: it is about a mesh that was there.
// `world_offset` is added to the vertices.
void WriteMeshWithViews(const std::filesystem::path& mesh_path, const TriangleMesh& mesh,
                        const Eigen::Vector3d& world_offset,
                        const std::optional<PointViews>& views);

}  // namespace lsmvs
