#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <optional>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Where a ray meets a surface.
struct RayHit {
  double distance = 0;                               // from the origin, along the unit direction
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit length, outward
};

// Closest point of a surface.
struct SurfacePoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit length, outward
  double signed_distance = 0;                        // of the query point: negative inside
};

// A solid with a known surface: the truth that results are compared with. World coordinates, double
// precision: hits, normals and distances are exact to about 1e-9 of the shape's size. Immutable and
// thread-safe.
class Shape {
 public:
  virtual ~Shape() = default;

  // First point of the surface on the ray from `origin` (outside of the solid) along the unit
  // vector `direction`.
  virtual std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction) const = 0;
  virtual SurfacePoint Closest(const Eigen::Vector3d& x) const = 0;
  virtual Eigen::AlignedBox3d Bounds() const = 0;
  // Triangles with edges of about `edge_length` or less, with vertices on the surface; closed and
  // oriented outward. Flat shapes are met exactly, curved ones to about edge_length^2 / (8 * radius
  // of curvature).
  virtual TriangleMesh Mesh(double edge_length) const = 0;

  double SignedDistance(const Eigen::Vector3d& x) const { return Closest(x).signed_distance; }
};

using ShapePtr = std::shared_ptr<const Shape>;

}  // namespace lsmvs
