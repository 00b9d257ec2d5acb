#include "lsmvs/refinement/step/noise_filter.h"

#include "lsmvs/mesh/normal_filter.h"
#include "lsmvs/mesh/undo_collisions.h"

namespace lsmvs {

namespace {
constexpr double kMaxRoundingPx = 1e-3;
}  // namespace

void FilterNoise(int num_passes, double max_edge_px, const std::vector<double>& pixel_size,
                 TriangleMesh* mesh, const RunContext& context) {
  if (num_passes == 0) return;
  std::vector<double> limits = ShortestEdges(*mesh);
  for (size_t v = 0; v < limits.size(); ++v) {
    if (!(limits[v] <= max_edge_px * pixel_size[v])) limits[v] = 0;
  }
  const std::vector<Eigen::Vector3d> before = mesh->vertices;
  FilterNormals({.num_passes = num_passes}, limits, context, mesh);
  for (size_t v = 0; v < limits.size(); ++v) {
    if (mesh->vertices[v] == before[v]) continue;
    mesh->vertices[v] = RoundToFile(mesh->vertices[v], kMaxRoundingPx * pixel_size[v]);
  }
  UndoCollisions(mesh->faces, before, &mesh->vertices, context);
}

}  // namespace lsmvs
