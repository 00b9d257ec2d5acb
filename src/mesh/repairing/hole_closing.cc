#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "lsmvs/mesh/polygon_triangulation.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/mesh/self_intersections.h"

namespace lsmvs {

namespace {

using Edge = std::pair<int, int>;

// All edges of the mesh among the vertices of the loops.
std::vector<Edge> EdgesAmong(const TriangleMesh& mesh, const std::vector<std::vector<int>>& loops) {
  std::vector<bool> on_loop(mesh.vertices.size(), false);
  for (const auto& loop : loops) {
    for (const int v : loop) on_loop[v] = true;
  }
  std::vector<Edge> edges;
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const int a = face[k], b = face[(k + 1) % 3];
      if (on_loop[a] && on_loop[b]) edges.push_back(std::minmax(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

// Triangulation of one loop of least area. Empty if there is none.
std::vector<Eigen::Vector3i> FillLoop(const TriangleMesh& mesh, const std::vector<int>& loop,
                                      const std::vector<Edge>& edges,
                                      const HoleClosingOptions& options) {
  const auto area = [&](size_t i, size_t k, size_t j) {
    const Eigen::Vector3d& a = mesh.vertices[loop[i]];
    const double size = 0.5 * (mesh.vertices[loop[k]] - a).cross(mesh.vertices[loop[j]] - a).norm();
    const bool is_accepted =
        size > 0 && (!options.accept || options.accept({loop[i], loop[k], loop[j]}));
    return is_accepted ? size : std::numeric_limits<double>::infinity();
  };
  const auto may_join = [&](size_t i, size_t j) {
    return !std::binary_search(edges.begin(), edges.end(), Edge(std::minmax(loop[i], loop[j])));
  };
  std::vector<Eigen::Vector3i> faces = TriangulatePolygon(loop.size(), area, may_join);
  for (Eigen::Vector3i& face : faces) {
    for (int& v : face) v = loop[static_cast<size_t>(v)];
  }
  return faces;
}

// Drops the patches of new faces that pass through others; patch_begin[i] is the first face of the
// i-th, its back the number of faces. Of two patches that cross, the later goes. Returns the number
// dropped.
size_t DropCrossingPatches(const std::vector<size_t>& patch_begin, const RunContext& context,
                           TriangleMesh* mesh) {
  const size_t first_new = patch_begin.front(), num_patches = patch_begin.size() - 1;
  if (first_new == mesh->faces.size()) return 0;
  std::vector<uint8_t> is_new(mesh->faces.size(), 0);
  std::fill(is_new.begin() + static_cast<std::ptrdiff_t>(first_new), is_new.end(), uint8_t{1});
  const auto patch_of = [&](size_t f) {
    const auto after = std::upper_bound(patch_begin.begin(), patch_begin.end(), f);
    return static_cast<size_t>(after - patch_begin.begin()) - 1;
  };
  std::vector<uint8_t> crosses(num_patches, 0);
  const FaceGrid grid(mesh->vertices, mesh->faces);
  for (const auto& [other, face] : grid.CrossingPairs(is_new, context)) {
    crosses[patch_of(static_cast<size_t>(face))] = 1;  // the higher index: a new face
  }
  FilterFaces(mesh, [&](size_t f) { return f < first_new || !crosses[patch_of(f)]; });
  return static_cast<size_t>(std::count(crosses.begin(), crosses.end(), 1));
}

}  // namespace

size_t CloseHoles(const HoleClosingOptions& options, const RunContext& context,
                  TriangleMesh* mesh) {
  std::vector<std::vector<int>> loops = FindBorderLoops(*mesh);
  std::erase_if(loops, [&](const std::vector<int>& loop) {
    return loop.size() < 3 || loop.size() > static_cast<size_t>(options.max_num_edges);
  });
  const std::vector<Edge> edges = EdgesAmong(*mesh, loops);
  std::vector<size_t> patch_begin = {mesh->faces.size()};
  for (const std::vector<int>& loop : loops) {
    const std::vector<Eigen::Vector3i> faces = FillLoop(*mesh, loop, edges, options);
    if (faces.empty()) continue;
    mesh->faces.insert(mesh->faces.end(), faces.begin(), faces.end());
    patch_begin.push_back(mesh->faces.size());
  }
  const size_t num_crossing = DropCrossingPatches(patch_begin, context, mesh);
  return patch_begin.size() - 1 - num_crossing;
}

}  // namespace lsmvs
