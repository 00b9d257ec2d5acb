#include "lsmvs/merging/vertex_views.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/mesh/edge_lengths.h"

namespace lsmvs {

namespace {

constexpr int kMaxImageSize = 1000;
constexpr size_t kVerticesPerBlock = 1 << 12;
// A face hides a vertex that lies so many edge lengths behind it.
constexpr double kTolerance = 2;
constexpr double kMinCosine = 0.1;

}  // namespace

PinholeCamera DrawingCamera(const PinholeCamera& camera) {
  const int longer = std::max(camera.width, camera.height);
  if (longer <= kMaxImageSize) return camera;
  const double scale = static_cast<double>(kMaxImageSize) / longer;
  const auto side = [&](int size) {
    return std::max(1, static_cast<int>(std::lround(scale * size)));
  };
  return camera.Resized(side(camera.width), side(camera.height));
}

VertexViews FindVertexViews(const TriangleMesh& mesh, std::span<const View> views,
                            const RunContext& context) {
  const size_t num_vertices = mesh.vertices.size();
  const std::vector<Eigen::Vector3f> normals = ComputeVertexNormals(mesh);
  const double tolerance = kTolerance * MeanEdgeLength(mesh);
  std::vector<std::vector<uint32_t>> seen(views.size());
  std::vector<uint8_t> sees(num_vertices);
  const FaceBlocks blocks(mesh.vertices, mesh.faces, context);
  SurfaceMaps maps;
  for (size_t i = 0; i < views.size(); ++i) {
    context.ThrowIfCancelled();
    const PinholeCamera camera = DrawingCamera(views[i].camera);
    RasterizeMesh(camera, views[i].cam_from_world, mesh.vertices, mesh.faces, {.blocks = &blocks},
                  &maps);
    const Eigen::Vector3d center = views[i].CenterInWorld();
    ParallelFor(context, num_vertices, kVerticesPerBlock, [&](size_t v) {
      sees[v] = 0;
      const Eigen::Vector3d x = views[i].cam_from_world * mesh.vertices[v];
      const Eigen::Vector3d to_view = (center - mesh.vertices[v]).normalized();
      if (!(x.z() > 0) || !(normals[v].cast<double>().dot(to_view) > kMinCosine)) return;
      const Eigen::Vector2d x_px = camera.Project(x);
      if (!camera.Contains(x_px)) return;
      const float depth = maps.depth(static_cast<int>(x_px.x()), static_cast<int>(x_px.y()));
      sees[v] = depth <= 0 || depth > x.z() - tolerance;
    });
    for (size_t v = 0; v < num_vertices; ++v) {
      if (sees[v]) seen[i].push_back(static_cast<uint32_t>(v));
    }
  }
  VertexViews result;
  result.view_begin.assign(num_vertices + 1, 0);
  for (const auto& list : seen) {
    for (const uint32_t v : list) ++result.view_begin[v + 1];
  }
  for (size_t v = 0; v < num_vertices; ++v) result.view_begin[v + 1] += result.view_begin[v];
  result.view_idxs.resize(result.view_begin.back());
  std::vector<uint64_t> next(result.view_begin.begin(), result.view_begin.end() - 1);
  for (size_t i = 0; i < seen.size(); ++i) {
    for (const uint32_t v : seen[i]) result.view_idxs[next[v]++] = static_cast<uint32_t>(i);
  }
  return result;
}

}  // namespace lsmvs
