#include "lsmvs/workflow/files/mesh_with_views.h"

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/mesh/ply.h"

namespace lsmvs {

namespace fs = std::filesystem;

std::vector<fs::path> MeshWithViewsFiles(const fs::path& mesh_path) {
  return {mesh_path, DenseWorkspace::VisibilityPath(mesh_path)};
}

std::optional<PointViews> ReadViewsOf(const fs::path& mesh_path, size_t num_vertices) {
  const fs::path vis_path = DenseWorkspace::VisibilityPath(mesh_path);
  if (!fs::exists(vis_path)) return std::nullopt;
  return ReadVisibility(vis_path, num_vertices);
}

void WriteMeshWithViews(const fs::path& mesh_path, const TriangleMesh& mesh,
                        const Eigen::Vector3d& world_offset,
                        const std::optional<PointViews>& views) {
  const fs::path vis_path = DenseWorkspace::VisibilityPath(mesh_path);
  fs::remove(vis_path);
  WriteMeshPly(mesh_path, mesh, world_offset);
  if (views) WriteVisibility(vis_path, views->begin, views->view_idxs);
}

}  // namespace lsmvs
