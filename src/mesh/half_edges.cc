#include "lsmvs/mesh/half_edges.h"

#include <algorithm>
#include <tuple>

namespace lsmvs {

std::vector<HalfEdge> SortedHalfEdges(std::span<const Eigen::Vector3i> faces, size_t num_vertices) {
  std::vector<uint32_t> ends(num_vertices + 1, 0);
  const auto low_of = [](const Eigen::Vector3i& f, int k) {
    return std::min(f[k], f[(k + 1) % 3]);
  };
  for (const Eigen::Vector3i& f : faces) {
    for (int k = 0; k < 3; ++k) ++ends[static_cast<size_t>(low_of(f, k)) + 1];
  }
  for (size_t v = 0; v < num_vertices; ++v) ends[v + 1] += ends[v];
  std::vector<HalfEdge> sides(3 * faces.size());
  // ends[v], where the sides of v begin, moves to where they end.
  for (size_t f = 0; f < faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int low = low_of(faces[f], k), high = std::max(faces[f][k], faces[f][(k + 1) % 3]);
      sides[ends[static_cast<size_t>(low)]++] = {low, high, static_cast<int32_t>(f), k};
    }
  }
  for (size_t v = 0; v < num_vertices; ++v) {
    std::sort(sides.begin() + (v == 0 ? 0 : ends[v - 1]), sides.begin() + ends[v],
              [](const HalfEdge& a, const HalfEdge& b) {
                return std::tie(a.high, a.face, a.corner) < std::tie(b.high, b.face, b.corner);
              });
  }
  return sides;
}

}  // namespace lsmvs
