#include "lsmvs/mesh/spikes.h"

#include <algorithm>
#include <limits>

#include "lsmvs/mesh/undo_collisions.h"
#include "lsmvs/mesh/vertex_rings.h"

namespace lsmvs {

namespace {

constexpr int kMaxRounds = 6;
// A regular tetrahedron's tip has 1.4: no corner of a solid that is not needle-sharp is a spike.
constexpr double kHeightOverRadius = 1.5;

struct Ring {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius = 0;  // mean distance from the middle
  double least_edge = std::numeric_limits<double>::infinity();
};

Ring MeasureRing(const TriangleMesh& mesh, const VertexRings& rings, size_t v) {
  const auto first = rings.neighbors.begin() + rings.begin[v],
             last = rings.neighbors.begin() + rings.begin[v + 1];
  const auto count = static_cast<double>(last - first);
  Ring ring;
  for (auto it = first; it != last; ++it) {
    const Eigen::Vector3d& x = mesh.vertices[static_cast<size_t>(*it)];
    ring.middle += x / count;
    ring.least_edge = std::min(ring.least_edge, (x - mesh.vertices[v]).norm());
  }
  for (auto it = first; it != last; ++it) {
    ring.radius += (mesh.vertices[static_cast<size_t>(*it)] - ring.middle).norm() / count;
  }
  return ring;
}

}  // namespace

size_t SinkSpikes(const std::vector<double>& least_edges, const RunContext& context,
                  TriangleMesh* mesh) {
  const VertexRings rings = BuildVertexRings(*mesh);
  std::vector<Eigen::Vector3d> before;
  std::vector<std::pair<size_t, Eigen::Vector3d>> moves;
  for (int round = 0; round < kMaxRounds; ++round) {
    moves.clear();
    for (size_t v = 0; v < mesh->vertices.size(); ++v) {
      if (rings.on_border[v] || rings.begin[v] == rings.begin[v + 1]) continue;
      const Ring ring = MeasureRing(*mesh, rings, v);
      const double height = (mesh->vertices[v] - ring.middle).norm();
      if (ring.least_edge < least_edges[v] || height <= kHeightOverRadius * ring.radius) continue;
      moves.emplace_back(v, ring.middle);
    }
    if (moves.empty()) break;
    if (before.empty()) before = mesh->vertices;
    for (const auto& [v, middle] : moves) {
      mesh->vertices[v] = RoundToFile(middle, 1e-4 * (mesh->vertices[v] - middle).norm());
    }
  }
  if (before.empty()) return 0;
  UndoCollisions(mesh->faces, before, &mesh->vertices, context);
  size_t num_moved = 0;
  for (size_t v = 0; v < before.size(); ++v) num_moved += before[v] != mesh->vertices[v];
  return num_moved;
}

}  // namespace lsmvs
