#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lsmvs/geometry/distances.h"

namespace lsmvs {

// Degenerate triangles (i, i, i), i < count: to index points.
std::vector<Eigen::Vector3i> PointFaces(size_t count);

// Finds the point of a set of triangles that is nearest to another, in double precision. Triangles
// may be degenerate: an edge is one that names a vertex twice. Keeps spans of vertices and faces.
// Queries are thread-safe. Building takes O(F log F); 16 bytes per face.
class SurfaceIndex {
 public:
  struct Hit {
    int32_t face = -1;  // -1: nothing is near enough
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double distance = std::numeric_limits<double>::infinity();
  };

  SurfaceIndex(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3i> faces);

  // Of the faces for which accept(face) holds; nothing that is `max_distance` away or farther.
  template <class Accept>
  Hit Closest(const Eigen::Vector3d& x, double max_distance, const Accept& accept) const;
  Hit Closest(const Eigen::Vector3d& x, double max_distance) const {
    return Closest(x, max_distance, [](int32_t) { return true; });
  }

 private:
  static constexpr size_t kLeafSize = 8;

  Triangle3 TriangleOf(int32_t face) const {
    const Eigen::Vector3i& f = faces_[static_cast<size_t>(face)];
    return {vertices_[static_cast<size_t>(f[0])], vertices_[static_cast<size_t>(f[1])],
            vertices_[static_cast<size_t>(f[2])]};
  }

  std::span<const Eigen::Vector3d> vertices_;
  std::span<const Eigen::Vector3i> faces_;
  std::vector<uint32_t> order_;  // faces along a Hilbert curve; leaf i holds kLeafSize from i on
  size_t num_leaves_ = 0;        // a power of two
  std::vector<Eigen::AlignedBox3d> boxes_;  // a complete binary tree: children of i: 2 i, 2 i + 1
};

template <class Accept>
SurfaceIndex::Hit SurfaceIndex::Closest(const Eigen::Vector3d& x, double max_distance,
                                        const Accept& accept) const {
  Hit hit;
  if (order_.empty()) return hit;
  double squared_limit = max_distance * max_distance;
  struct Entry {
    size_t node;
    double squared_distance;
  };
  std::array<Entry, 128> stack;
  size_t size = 0;
  const auto push = [&](size_t node) {
    const double squared = boxes_[node].squaredExteriorDistance(x);
    if (squared < squared_limit) stack[size++] = {node, squared};
  };
  push(1);
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.squared_distance >= squared_limit) continue;
    if (entry.node < num_leaves_) {
      const size_t first = size;
      push(2 * entry.node);
      push(2 * entry.node + 1);
      // The nearer one is looked at first.
      if (size == first + 2 && stack[first].squared_distance < stack[first + 1].squared_distance) {
        std::swap(stack[first], stack[first + 1]);
      }
      continue;
    }
    const size_t begin = (entry.node - num_leaves_) * kLeafSize;
    for (size_t i = begin; i < std::min(begin + kLeafSize, order_.size()); ++i) {
      const int32_t face = static_cast<int32_t>(order_[i]);
      const Eigen::Vector3d point = ClosestOnTriangle(x, TriangleOf(face));
      const double squared = (point - x).squaredNorm();
      if (squared >= squared_limit || !accept(face)) continue;
      squared_limit = squared;
      hit.face = face;
      hit.point = point;
    }
  }
  if (hit.face >= 0) hit.distance = std::sqrt(squared_limit);
  return hit;
}

}  // namespace lsmvs
