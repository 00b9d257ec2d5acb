#include "lsmvs/mesh/face_neighbors.h"

#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

FaceNeighbors FindFaceNeighbors(std::span<const Eigen::Vector3i> faces, size_t num_vertices) {
  FaceNeighbors neighbors(faces.size(), {-1, -1, -1});
  const auto set = [&](const HalfEdge& side, int32_t other) {
    neighbors[static_cast<size_t>(side.face)][static_cast<size_t>(side.corner)] = other;
  };
  ForEdges(SortedHalfEdges(faces, num_vertices), [&](const HalfEdge* begin, const HalfEdge* end) {
    if (end - begin != 2 || begin[0].face == begin[1].face) return;
    set(begin[0], begin[1].face);
    set(begin[1], begin[0].face);
  });
  return neighbors;
}

}  // namespace lsmvs
