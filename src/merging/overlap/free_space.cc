#include "lsmvs/merging/overlap/free_space.h"

#include <algorithm>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/merging/vertex_views.h"

namespace lsmvs {

namespace {

constexpr int kMinNumViews = 2;

// Per view, the vertices that it sees.
std::vector<std::vector<uint32_t>> SeenVertices(const SourcedMesh& mesh, size_t num_views,
                                                const VisitViews& visit_views) {
  std::vector<std::vector<uint32_t>> seen(num_views);
  for (size_t v = 0; v < mesh.sources.size(); ++v) {
    visit_views(mesh.sources[v], [&](uint32_t view) {
      if (view < num_views) seen[view].push_back(static_cast<uint32_t>(v));
    });
  }
  return seen;
}

}  // namespace

std::vector<uint8_t> FindVerticesInFreeSpace(const TriangleMesh& mesh, const SourcedMesh& other,
                                             const std::vector<View>& views,
                                             const VisitViews& visit_views, double margin,
                                             const RunContext& context) {
  std::vector<uint8_t> num_contradictions(mesh.vertices.size(), 0);
  const auto seen = SeenVertices(other, views.size(), visit_views);
  SurfaceMaps maps;
  for (size_t i = 0; i < views.size(); ++i) {
    if (seen[i].empty()) continue;
    context.ThrowIfCancelled();
    std::vector<uint8_t> is_seen(other.mesh.vertices.size(), 0);
    for (const uint32_t v : seen[i]) is_seen[v] = 1;
    const PinholeCamera camera = DrawingCamera(views[i].camera);
    RasterizeMesh(camera, views[i].cam_from_world, other.mesh.vertices, other.mesh.faces, {},
                  &maps);
    ParallelFor(context, mesh.vertices.size(), 1 << 12, [&](size_t v) {
      const Eigen::Vector3d x = views[i].cam_from_world * mesh.vertices[v];
      if (!(x.z() > 0)) return;
      const Eigen::Vector2d x_px = camera.Project(x);
      if (!camera.Contains(x_px)) return;
      const int column = static_cast<int>(x_px.x()), row = static_cast<int>(x_px.y());
      const int32_t face = maps.face(column, row);
      if (face < 0 || maps.depth(column, row) < x.z() + margin) return;
      const Eigen::Vector3i& corners = other.mesh.faces[static_cast<size_t>(face)];
      const bool sees = std::any_of(corners.begin(), corners.end(),
                                    [&](int w) { return is_seen[static_cast<size_t>(w)] != 0; });
      if (sees && num_contradictions[v] < kMinNumViews) ++num_contradictions[v];
    });
  }
  for (uint8_t& count : num_contradictions) count = count >= kMinNumViews;
  return num_contradictions;
}

}  // namespace lsmvs
