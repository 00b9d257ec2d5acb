#include "lsmvs/refinement/regions/face_regions.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

namespace {

constexpr int32_t kNone = -1;

// #F: the faces across the three edges; of an edge with more than two faces the next in a ring.
std::vector<std::array<int32_t, 3>> FaceNeighbors(const TriangleMesh& mesh) {
  std::vector<std::array<int32_t, 3>> neighbors(mesh.faces.size(), {kNone, kNone, kNone});
  const std::vector<HalfEdge> sides = SortedHalfEdges(mesh.faces, mesh.vertices.size());
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    for (const HalfEdge* side = begin; side != end && end - begin > 1; ++side) {
      const HalfEdge* next = side + 1 == end ? begin : side + 1;
      neighbors[static_cast<size_t>(side->face)][static_cast<size_t>(side->corner)] = next->face;
    }
  });
  return neighbors;
}

// Sorts the faces by keys below `num_keys`, those with the same key as before, and the vertices as
// faces first use them.
void Reorder(const std::vector<int32_t>& key_of_face, size_t num_keys, TriangleMesh* mesh,
             std::vector<Eigen::Vector3d>* rest) {
  std::vector<size_t> next(num_keys + 1, 0);
  for (const int32_t key : key_of_face) ++next[static_cast<size_t>(key) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<Eigen::Vector3i> faces(mesh->faces.size());
  for (size_t f = 0; f < faces.size(); ++f) {
    faces[next[static_cast<size_t>(key_of_face[f])]++] = mesh->faces[f];
  }
  std::vector<Eigen::Vector3d> vertices, places;
  vertices.reserve(mesh->vertices.size());
  places.reserve(mesh->vertices.size());
  std::vector<int32_t> index(mesh->vertices.size(), kNone);
  for (Eigen::Vector3i& face : faces) {
    for (int& v : face) {
      int32_t& to = index[static_cast<size_t>(v)];
      if (to == kNone) {
        to = static_cast<int32_t>(vertices.size());
        vertices.push_back(mesh->vertices[static_cast<size_t>(v)]);
        places.push_back((*rest)[static_cast<size_t>(v)]);
      }
      v = to;
    }
  }
  mesh->faces.swap(faces);
  mesh->vertices.swap(vertices);
  rest->swap(places);
}

}  // namespace

FaceRegions GrowFaceRegions(const TriangleMesh& mesh, int faces_per_region) {
  const auto neighbors = FaceNeighbors(mesh);
  FaceRegions regions;
  regions.of_face.assign(mesh.faces.size(), kNone);
  std::vector<int32_t> queue;
  for (size_t seed = 0; seed < mesh.faces.size(); ++seed) {
    if (regions.of_face[seed] != kNone) continue;
    queue.assign(1, static_cast<int32_t>(seed));
    regions.of_face[seed] = regions.count;
    int32_t lowest_neighbor = kNone;
    for (size_t head = 0; head < queue.size(); ++head) {
      for (const int32_t next : neighbors[static_cast<size_t>(queue[head])]) {
        if (next == kNone) continue;
        int32_t& region = regions.of_face[static_cast<size_t>(next)];
        if (region == kNone && static_cast<int>(queue.size()) < faces_per_region) {
          region = regions.count;
          queue.push_back(next);
        } else if (region != kNone && region != regions.count) {
          lowest_neighbor = lowest_neighbor == kNone ? region : std::min(lowest_neighbor, region);
        }
      }
    }
    if (lowest_neighbor != kNone && static_cast<int>(4 * queue.size()) < faces_per_region) {
      for (const int32_t face : queue) regions.of_face[static_cast<size_t>(face)] = lowest_neighbor;
    } else {
      ++regions.count;
    }
  }
  return regions;
}

std::vector<int32_t> RegionsOfVertices(const TriangleMesh& mesh, const FaceRegions& regions) {
  std::vector<int32_t> of_vertex(mesh.vertices.size(), kNone);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      int32_t& region = of_vertex[static_cast<size_t>(v)];
      if (region == kNone) region = regions.of_face[f];
    }
  }
  return of_vertex;
}

void OrderAlongCurve(TriangleMesh* mesh, std::vector<Eigen::Vector3d>* rest) {
  std::vector<int32_t> ranks(mesh->vertices.size());
  const std::vector<uint32_t> order = HilbertOrder(mesh->vertices);
  for (size_t rank = 0; rank < order.size(); ++rank) {
    ranks[order[rank]] = static_cast<int32_t>(rank);
  }
  std::vector<int32_t> lowest(mesh->faces.size());
  for (size_t f = 0; f < lowest.size(); ++f) {
    const Eigen::Vector3i& v = mesh->faces[f];
    lowest[f] = std::min({ranks[static_cast<size_t>(v[0])], ranks[static_cast<size_t>(v[1])],
                          ranks[static_cast<size_t>(v[2])]});
  }
  Reorder(lowest, ranks.size(), mesh, rest);
}

void OrderByRegions(const FaceRegions& regions, TriangleMesh* mesh,
                    std::vector<Eigen::Vector3d>* rest) {
  Reorder(regions.of_face, static_cast<size_t>(regions.count), mesh, rest);
}

}  // namespace lsmvs
