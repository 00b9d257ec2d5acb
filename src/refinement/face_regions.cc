#include "lsmvs/refinement/face_regions.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace lsmvs {

namespace {

constexpr int32_t kNone = -1;

// #F: the faces across the three edges; of an edge with more than two faces the next in a ring.
std::vector<std::array<int32_t, 3>> FaceNeighbors(const TriangleMesh& mesh) {
  struct Side {
    int low, high;
    int32_t face;
    int corner;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int32_t>(f), k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
  });
  std::vector<std::array<int32_t, 3>> neighbors(mesh.faces.size(), {kNone, kNone, kNone});
  for (size_t begin = 0; begin < sides.size();) {
    size_t end = begin;
    while (end < sides.size() && sides[end].low == sides[begin].low &&
           sides[end].high == sides[begin].high) {
      ++end;
    }
    for (size_t s = begin; s < end && end - begin > 1; ++s) {
      const Side& next = sides[s + 1 < end ? s + 1 : begin];
      neighbors[static_cast<size_t>(sides[s].face)][static_cast<size_t>(sides[s].corner)] =
          next.face;
    }
    begin = end;
  }
  return neighbors;
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

}  // namespace lsmvs
