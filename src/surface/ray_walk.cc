#include "lsmvs/surface/ray_walk.h"

namespace lsmvs {

bool RayWalker::TurnsLeftTilted(const Projected& a, const Projected& b) {
  // The target moves by (e, e^2), so that (x, y) becomes (x - e z, y - e^2 z): terms in e, then in
  // e^2.
  const double first = static_cast<double>(a.y) * b.z - static_cast<double>(a.z) * b.y;
  if (first != 0) return first > 0;
  const double second = static_cast<double>(a.z) * b.x - static_cast<double>(a.x) * b.z;
  if (second != 0) return second > 0;
  return a.vertex < b.vertex;
}

int32_t RayWalker::FindStart(int32_t vertex, Projected* a, Projected* b, Projected* c,
                             int* exit) const {
  // Towards the ray through the facets at the vertex; in a Delaunay complex such walks end.
  int32_t current = complex_.incident_cell[vertex];
  constexpr int kMaxSteps = 100000;
  for (int step = 0; step < kMaxSteps && current >= 0; ++step) {
    if (complex_.IsInfinite(current)) return current;
    const Cell& cell = complex_.cells[current];
    const int k = cell.IndexOfVertex(vertex);
    const auto& facet = kFacetVertices[k];
    // Counter-clockwise from outside: the ray that leaves through it turns left around it.
    *a = Project(cell.vertex[facet[0]]);
    *b = Project(cell.vertex[facet[2]]);
    *c = Project(cell.vertex[facet[1]]);
    if (!TurnsLeft(*a, *b)) {
      current = cell.neighbor[facet[1]];
    } else if (!TurnsLeft(*b, *c)) {
      current = cell.neighbor[facet[0]];
    } else if (!TurnsLeft(*c, *a)) {
      current = cell.neighbor[facet[2]];
    } else {
      *exit = k;
      return current;
    }
  }
  return -1;
}

}  // namespace lsmvs
