#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace lsmvs {

// The triangulation of a closed polygon of mesh vertices, without new ones, of least total cost:
// squared lengths of the sides, and much more where a triangle is turned away from the normals
// (unit length) at its corners. Triangles run along the polygon in its direction. `may_join`: which
// diagonals are allowed. Empty if there is none. O(n^3), 12 bytes times n^2.
std::vector<Eigen::Vector3i> FillPolygon(std::span<const Eigen::Vector3d> vertices,
                                         std::span<const Eigen::Vector3d> normals,
                                         const std::vector<int32_t>& polygon,
                                         const std::function<bool(int32_t, int32_t)>& may_join);

}  // namespace lsmvs
