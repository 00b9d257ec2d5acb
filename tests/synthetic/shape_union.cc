#include "lsmvs/synthetic/shape_union.h"

#include <algorithm>

namespace lsmvs {

std::optional<RayHit> ShapeUnion::Intersect(const Eigen::Vector3d& origin,
                                            const Eigen::Vector3d& direction) const {
  std::optional<RayHit> nearest;
  for (const ShapePtr& part : parts_) {
    const std::optional<RayHit> hit = part->Intersect(origin, direction);
    if (hit && (!nearest || hit->distance < nearest->distance)) nearest = hit;
  }
  return nearest;
}

SurfacePoint ShapeUnion::Closest(const Eigen::Vector3d& x) const {
  SurfacePoint best = parts_.front()->Closest(x);
  double nearest_surface = std::abs(best.signed_distance);
  bool inside = best.signed_distance < 0;
  for (size_t p = 1; p < parts_.size(); ++p) {
    const SurfacePoint other = parts_[p]->Closest(x);
    inside = inside || other.signed_distance < 0;
    if (std::abs(other.signed_distance) < nearest_surface) {
      nearest_surface = std::abs(other.signed_distance);
      best = other;
    }
  }
  best.signed_distance = inside ? -nearest_surface : nearest_surface;
  return best;
}

Eigen::AlignedBox3d ShapeUnion::Bounds() const {
  Eigen::AlignedBox3d bounds;
  for (const ShapePtr& part : parts_) bounds.extend(part->Bounds());
  return bounds;
}

TriangleMesh ShapeUnion::Mesh(double edge_length) const {
  TriangleMesh mesh;
  for (const ShapePtr& part : parts_) {
    const TriangleMesh piece = part->Mesh(edge_length);
    const auto shift = Eigen::Vector3i::Constant(static_cast<int>(mesh.vertices.size()));
    mesh.vertices.insert(mesh.vertices.end(), piece.vertices.begin(), piece.vertices.end());
    for (const Eigen::Vector3i& face : piece.faces) mesh.faces.push_back(face + shift);
  }
  return mesh;
}

}  // namespace lsmvs
