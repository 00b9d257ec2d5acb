#include "lsmvs/mesh/vertex_rings.h"

#include <numeric>

#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

VertexRings BuildVertexRings(const TriangleMesh& mesh) {
  const std::vector<HalfEdge> sides = SortedHalfEdges(mesh.faces, mesh.vertices.size());
  VertexRings rings;
  rings.on_border.assign(mesh.vertices.size(), 0);
  rings.begin.assign(mesh.vertices.size() + 1, 0);
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    const size_t low = static_cast<size_t>(begin->low), high = static_cast<size_t>(begin->high);
    if (end - begin != 2) rings.on_border[low] = rings.on_border[high] = 1;
    ++rings.begin[low + 1];
    ++rings.begin[high + 1];
  });
  std::partial_sum(rings.begin.begin(), rings.begin.end(), rings.begin.begin());
  rings.neighbors.resize(static_cast<size_t>(rings.begin.back()));
  std::vector<int32_t> next(rings.begin.begin(), rings.begin.end() - 1);
  // Lower neighbours first, then higher ones: each list ascends because the edges are sorted.
  ForEdges(sides, [&](const HalfEdge* side, const HalfEdge*) {
    rings.neighbors[static_cast<size_t>(next[static_cast<size_t>(side->high)]++)] = side->low;
  });
  ForEdges(sides, [&](const HalfEdge* side, const HalfEdge*) {
    rings.neighbors[static_cast<size_t>(next[static_cast<size_t>(side->low)]++)] = side->high;
  });
  return rings;
}

}  // namespace lsmvs
