#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace lsmvs {

// One side of a face: the edge from corner `corner` to the next one.
struct HalfEdge {
  int32_t low, high;  // the vertices at its ends, low < high unless the face is degenerate
  int32_t face, corner;
};

// The sides of all faces, sorted by (low, high, face, corner): those of an edge lie together.
// O(#V + #F) for vertices of bounded degree; 16 bytes a side and 4 bytes a vertex.
std::vector<HalfEdge> SortedHalfEdges(std::span<const Eigen::Vector3i> faces, size_t num_vertices);

// Calls visit(begin, end) with the sides of each edge.
template <class Visit>
void ForEdges(const std::vector<HalfEdge>& sides, const Visit& visit) {
  const HalfEdge* end = sides.data() + sides.size();
  for (const HalfEdge* first = sides.data(); first != end;) {
    const HalfEdge* last = first + 1;
    while (last != end && last->low == first->low && last->high == first->high) ++last;
    visit(first, last);
    first = last;
  }
}

}  // namespace lsmvs
