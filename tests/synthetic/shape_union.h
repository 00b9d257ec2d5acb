#pragma once

#include <vector>

#include "lsmvs/synthetic/shape.h"

namespace lsmvs {

// Union of solids. Rays and distances from outside are exact. Inside, the distance is that to the
// nearest surface of a part, which may be hidden in another part: a lower bound. The mesh is that
// of the parts, one after the other, hidden pieces included (no camera sees them).
class ShapeUnion : public Shape {
 public:
  explicit ShapeUnion(std::vector<ShapePtr> parts) : parts_(std::move(parts)) {}

  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override;
  SurfacePoint Closest(const Eigen::Vector3d& x) const override;
  Eigen::AlignedBox3d Bounds() const override;
  TriangleMesh Mesh(double edge_length) const override;

 private:
  std::vector<ShapePtr> parts_;
};

}  // namespace lsmvs
