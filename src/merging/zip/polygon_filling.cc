#include "lsmvs/merging/zip/polygon_filling.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "lsmvs/mesh/polygon_triangulation.h"

namespace lsmvs {

namespace {

// How much a triangle costs that is turned over, in its squared sides.
constexpr double kTurnedCost = 20;
// Triangles may be turned from the normals by this cosine at no cost.
constexpr double kFreeCosine = 0.6;

double SquaredSides(const Eigen::Vector3d& ab, const Eigen::Vector3d& ac) {
  return ab.squaredNorm() + ac.squaredNorm() + (ac - ab).squaredNorm();
}

// Of a triangle, `expected` its normal but for the length.
double TriangleCost(const Eigen::Vector3d& ab, const Eigen::Vector3d& ac,
                    const Eigen::Vector3d& expected) {
  const double sides = SquaredSides(ab, ac);
  const Eigen::Vector3d normal = ab.cross(ac);
  const double twice_area = normal.norm();
  if (!(twice_area > 1e-9 * sides)) return (1 + 2 * kTurnedCost) * sides;
  const double cosine = normal.dot(expected) / (twice_area * std::max(expected.norm(), 1e-9));
  return sides * (1 + kTurnedCost * std::max(0.0, kFreeCosine - cosine));
}

}  // namespace

std::vector<Eigen::Vector3i> FillPolygon(std::span<const Eigen::Vector3d> vertices,
                                         std::span<const Eigen::Vector3d> normals,
                                         const std::vector<int32_t>& polygon,
                                         const std::function<bool(int32_t, int32_t)>& may_join) {
  const auto vertex = [&](size_t i) { return static_cast<size_t>(polygon[i]); };
  const auto cost = [&](size_t i, size_t k, size_t j) {
    const Eigen::Vector3d& a = vertices[vertex(i)];
    return TriangleCost(vertices[vertex(k)] - a, vertices[vertex(j)] - a,
                        normals[vertex(i)] + normals[vertex(k)] + normals[vertex(j)]);
  };
  std::vector<Eigen::Vector3i> faces = TriangulatePolygon(
      polygon.size(), cost, [&](size_t i, size_t j) { return may_join(polygon[i], polygon[j]); });
  for (Eigen::Vector3i& face : faces) {
    for (int& v : face) v = polygon[static_cast<size_t>(v)];
  }
  return faces;
}

}  // namespace lsmvs
