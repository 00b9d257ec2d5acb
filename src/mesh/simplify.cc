#include "lsmvs/mesh/simplify.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

#include "lsmvs/mesh/simplification/edge_collapser.h"
#include "lsmvs/mesh/simplification/proper_surface.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

using internal::ProperSurface;

constexpr size_t kThinningFactor = 16;

double Area(const ProperSurface& surface) {
  double sum = 0;
  for (const Eigen::Vector3i& f : surface.faces) {
    const Eigen::Vector3d& a = surface.vertices[f[0]];
    sum += 0.5 * (surface.vertices[f[1]] - a).cross(surface.vertices[f[2]] - a).norm();
  }
  return sum;
}

struct CellHash {
  size_t operator()(const Eigen::Vector3i& c) const {
    return static_cast<size_t>(c.x()) * 73856093u ^ static_cast<size_t>(c.y()) * 19349663u ^
           static_cast<size_t>(c.z()) * 83492791u;
  }
};

// One vertex a cell of a grid: the one that is nearest to the cell's mean.
ProperSurface ThinOnGrid(const ProperSurface& surface, double cell_size) {
  std::unordered_map<Eigen::Vector3i, int, CellHash> cells;
  std::vector<int> cell_of(surface.vertices.size());
  std::vector<Eigen::Vector3d> sums;
  std::vector<int> counts;
  for (size_t v = 0; v < surface.vertices.size(); ++v) {
    const Eigen::Vector3d place = (surface.vertices[v] - surface.vertices[0]) / cell_size;
    const Eigen::Vector3i key =
        place.cwiseMax(-1e9).cwiseMin(1e9).array().floor().matrix().cast<int>();
    const auto [entry, is_new] = cells.try_emplace(key, static_cast<int>(sums.size()));
    if (is_new) {
      sums.emplace_back(Eigen::Vector3d::Zero());
      counts.push_back(0);
    }
    cell_of[v] = entry->second;
    sums[cell_of[v]] += surface.vertices[v];
    ++counts[cell_of[v]];
  }
  std::vector<int> chosen(sums.size(), -1);
  std::vector<double> chosen_distance(sums.size());
  for (size_t v = 0; v < surface.vertices.size(); ++v) {
    const int cell = cell_of[v];
    const double distance = (surface.vertices[v] - sums[cell] / counts[cell]).squaredNorm();
    if (chosen[cell] >= 0 && distance >= chosen_distance[cell]) continue;
    chosen[cell] = static_cast<int>(v);
    chosen_distance[cell] = distance;
  }
  ProperSurface thin;
  thin.origin = surface.origin;
  for (const int v : chosen) {
    thin.vertices.push_back(surface.vertices[v]);
    thin.source.push_back(surface.source[v]);
  }
  for (const Eigen::Vector3i& f : surface.faces) {
    Eigen::Vector3i renamed(cell_of[f[0]], cell_of[f[1]], cell_of[f[2]]);
    if (renamed[0] == renamed[1] || renamed[1] == renamed[2] || renamed[2] == renamed[0]) continue;
    while (renamed[0] > renamed[1] || renamed[0] > renamed[2]) {
      renamed = Eigen::Vector3i(renamed[1], renamed[2], renamed[0]);
    }
    thin.faces.push_back(renamed);
  }
  const auto key = [](const Eigen::Vector3i& f) { return std::tuple(f[0], f[1], f[2]); };
  std::sort(thin.faces.begin(), thin.faces.end(),
            [&](const auto& a, const auto& b) { return key(a) < key(b); });
  thin.faces.erase(std::unique(thin.faces.begin(), thin.faces.end()), thin.faces.end());
  return thin;
}

// `is_locked` is #V of the surface, or empty.
void Collapse(size_t max_faces, const std::vector<uint8_t>& is_locked, const RunContext& context,
              ProperSurface* surface) {
  internal::VertexStars stars(std::move(surface->vertices), std::move(surface->faces));
  internal::EdgeCollapser collapser({}, {}, &stars, nullptr);
  if (!is_locked.empty()) collapser.Lock(is_locked);
  collapser.Run(max_faces, context);
  surface->vertices = stars.positions();
  surface->faces = stars.Faces();
  std::vector<int> source;
  for (const int32_t v : collapser.sources()) source.push_back(surface->source[v]);
  surface->source = std::move(source);
}

}  // namespace

SimplifiedMesh SimplifyMesh(const TriangleMesh& mesh, size_t max_faces, const RunContext& context) {
  LSMVS_CHECK_GE(max_faces, size_t{4});
  ProperSurface surface = internal::ProperPart(mesh);
  double cell = std::sqrt(2 * Area(surface) / static_cast<double>(kThinningFactor * max_faces));
  for (; surface.faces.size() > kThinningFactor * max_faces && cell > 0; cell *= 1.3) {
    ProperSurface thin = ThinOnGrid(surface, cell);
    if (thin.faces.size() < max_faces) break;
    surface = std::move(thin);
  }
  if (surface.faces.size() > max_faces) Collapse(max_faces, {}, context, &surface);
  for (Eigen::Vector3d& x : surface.vertices) x += surface.origin;
  SimplifiedMesh result = internal::CompactMesh(surface.vertices, surface.faces, surface.source);
  result.mesh.vertex_colors = CarryToSimplified(result, mesh.vertex_colors);
  return result;
}

SimplifiedMesh SimplifyMeshPart(const TriangleMesh& mesh, const std::vector<uint8_t>& is_locked,
                                size_t max_faces, const RunContext& context) {
  LSMVS_CHECK_EQ(is_locked.size(), mesh.vertices.size());
  ProperSurface surface = internal::ProperPart(mesh);
  std::vector<uint8_t> locked;
  for (const int v : surface.source) locked.push_back(is_locked[static_cast<size_t>(v)]);
  if (surface.faces.size() > max_faces) Collapse(max_faces, locked, context, &surface);
  for (size_t v = 0; v < surface.vertices.size(); ++v) {
    const size_t source = static_cast<size_t>(surface.source[v]);
    surface.vertices[v] =  // to the last bit where it is locked
        is_locked[source] ? mesh.vertices[source] : surface.vertices[v] + surface.origin;
  }
  SimplifiedMesh result = internal::CompactMesh(surface.vertices, surface.faces, surface.source);
  result.mesh.vertex_colors = CarryToSimplified(result, mesh.vertex_colors);
  return result;
}

}  // namespace lsmvs
