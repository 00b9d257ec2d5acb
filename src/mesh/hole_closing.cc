#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "lsmvs/mesh/face_crossings.h"
#include "lsmvs/mesh/repair.h"

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

// Triangulation of one loop of least area (G. Klincsek: Minimal triangulations of polygonal
// domains, 1980).
class LoopFiller {
 public:
  LoopFiller(const TriangleMesh& mesh, const std::vector<int>& loop, const std::vector<Edge>& edges,
             const HoleClosingOptions& options)
      : mesh_(mesh),
        loop_(loop),
        edges_(edges),
        options_(options),
        n_(loop.size()),
        cost_(n_ * n_, std::numeric_limits<double>::infinity()),
        apex_(n_ * n_, -1) {}

  // Empty if there is none.
  std::vector<Eigen::Vector3i> Run() {
    for (size_t i = 0; i + 1 < n_; ++i) cost_[i * n_ + i + 1] = 0;
    for (size_t gap = 2; gap < n_; ++gap) {
      for (size_t i = 0; i + gap < n_; ++i) Solve(i, i + gap);
    }
    std::vector<Eigen::Vector3i> faces;
    if (cost_[n_ - 1] < std::numeric_limits<double>::infinity()) Collect(0, n_ - 1, &faces);
    return faces;
  }

 private:
  bool Accepted(size_t i, size_t k, size_t j) const {
    return !options_.accept || options_.accept({loop_[i], loop_[k], loop_[j]});
  }
  bool MayJoin(size_t i, size_t j) const {
    const bool side = j == i + 1 || (i == 0 && j + 1 == n_);
    return side ||
           !std::binary_search(edges_.begin(), edges_.end(), Edge(std::minmax(loop_[i], loop_[j])));
  }
  double Area(size_t i, size_t j, size_t k) const {
    const Eigen::Vector3d& a = mesh_.vertices[loop_[i]];
    return 0.5 * (mesh_.vertices[loop_[j]] - a).cross(mesh_.vertices[loop_[k]] - a).norm();
  }
  void Solve(size_t i, size_t j) {
    if (!MayJoin(i, j)) return;
    for (size_t k = i + 1; k < j; ++k) {
      const double area = Area(i, k, j);
      const double cost = cost_[i * n_ + k] + cost_[k * n_ + j] + area;
      if (!(area > 0) || cost >= cost_[i * n_ + j] || !Accepted(i, k, j)) continue;
      cost_[i * n_ + j] = cost;
      apex_[i * n_ + j] = static_cast<int>(k);
    }
  }
  void Collect(size_t i, size_t j, std::vector<Eigen::Vector3i>* faces) const {
    if (j == i + 1) return;
    const auto k = static_cast<size_t>(apex_[i * n_ + j]);
    faces->emplace_back(loop_[i], loop_[k], loop_[j]);
    Collect(i, k, faces);
    Collect(k, j, faces);
  }

  const TriangleMesh& mesh_;
  const std::vector<int>& loop_;
  const std::vector<Edge>& edges_;
  const HoleClosingOptions& options_;
  size_t n_;
  std::vector<double> cost_;  // of the best triangulation between loop positions i < j
  std::vector<int> apex_;
};

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
    const std::vector<Eigen::Vector3i> faces = LoopFiller(*mesh, loop, edges, options).Run();
    if (faces.empty()) continue;
    mesh->faces.insert(mesh->faces.end(), faces.begin(), faces.end());
    patch_begin.push_back(mesh->faces.size());
  }
  const size_t num_crossing = DropCrossingPatches(patch_begin, context, mesh);
  return patch_begin.size() - 1 - num_crossing;
}

}  // namespace lsmvs
