#include "lsmvs/exporting/tiles/same_side.h"

namespace lsmvs {

namespace {

constexpr int kMostHits = 8;

bool LooksAlong(const TriangleMesh& mesh, int face, const Eigen::Vector3d& normal) {
  return FaceNormalTimesTwiceArea(mesh, static_cast<size_t>(face)).dot(normal) > 0;
}

// The first face along a unit direction that looks along `normal`.
std::optional<ClosestPoint> FirstAlong(const MeshTracer& tracer, const TriangleMesh& mesh,
                                       const Eigen::Vector3d& x, const Eigen::Vector3d& direction,
                                       const Eigen::Vector3d& normal, double reach) {
  double begin = 0;
  for (int i = 0; i < kMostHits; ++i) {
    const std::optional<MeshHit> hit = tracer.Cast(x, direction, begin, reach);
    if (!hit) return std::nullopt;
    if (LooksAlong(mesh, hit->face, normal)) {
      return ClosestPoint{hit->distance, hit->face, x + hit->distance * direction};
    }
    begin = hit->distance + 1e-5 * reach;
  }
  return std::nullopt;
}

}  // namespace

std::optional<ClosestPoint> ClosestOnSameSide(const MeshTracer& tracer, const TriangleMesh& mesh,
                                              const Eigen::Vector3d& x,
                                              const Eigen::Vector3d& normal, double reach) {
  const std::optional<ClosestPoint> nearest = tracer.Closest(x);
  if (!nearest || normal.isZero() || LooksAlong(mesh, nearest->face, normal)) return nearest;
  const Eigen::Vector3d direction = normal.normalized();
  const auto above = FirstAlong(tracer, mesh, x, direction, normal, reach);
  const auto below = FirstAlong(tracer, mesh, x, -direction, normal, reach);
  if (!above && !below) return nearest;
  return !below || (above && above->distance <= below->distance) ? above : below;
}

}  // namespace lsmvs
