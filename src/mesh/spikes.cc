#include "lsmvs/mesh/spikes.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "lsmvs/mesh/undo_collisions.h"
#include "lsmvs/mesh/vertex_rings.h"

namespace lsmvs {

namespace {

constexpr size_t kVerticesPerBlock = 8192;
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

// Moves the spikes of one round. False if there are none.
bool SinkOnce(const VertexRings& rings, const std::vector<double>& least_edges,
              const RunContext& context, TriangleMesh* mesh) {
  std::vector<uint8_t> is_spike(mesh->vertices.size(), 0);
  ParallelFor(context, is_spike.size(), kVerticesPerBlock, [&](size_t v) {
    if (rings.on_border[v] || rings.begin[v] == rings.begin[v + 1]) return;
    const Ring ring = MeasureRing(*mesh, rings, v);
    const double height = (mesh->vertices[v] - ring.middle).norm();
    is_spike[v] =
        ring.least_edge >= least_edges[v] && height > kHeightOverRadius * ring.radius ? 1 : 0;
  });
  std::vector<std::pair<size_t, Eigen::Vector3d>> moves;
  for (size_t v = 0; v < is_spike.size(); ++v) {
    if (is_spike[v]) moves.emplace_back(v, MeasureRing(*mesh, rings, v).middle);
  }
  for (const auto& [v, middle] : moves) mesh->vertices[v] = middle;
  return !moves.empty();
}

}  // namespace

std::vector<int32_t> SinkSpikes(const std::vector<double>& least_edges, const RunContext& context,
                                TriangleMesh* mesh) {
  const std::vector<Eigen::Vector3d> before = mesh->vertices;
  bool any = false;
  {
    const VertexRings rings = BuildVertexRings(*mesh);
    for (int round = 0; round < kMaxRounds; ++round) {
      if (!SinkOnce(rings, least_edges, context, mesh)) break;
      any = true;
    }
  }
  if (any) UndoCollisions(mesh->faces, before, &mesh->vertices, context, true);
  std::vector<int32_t> moved;
  for (size_t v = 0; v < before.size(); ++v) {
    if (mesh->vertices[v] != before[v]) moved.push_back(static_cast<int32_t>(v));
  }
  return moved;
}

}  // namespace lsmvs
