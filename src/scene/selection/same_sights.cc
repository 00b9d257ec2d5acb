#include "lsmvs/scene/selection/same_sights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lsmvs/geometry/triangulation.h"
#include "lsmvs/scene/center_groups.h"

namespace lsmvs {

namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr double kMinSharedPart = 0.75, kMaxScaleRatio = 1.5, kMaxAxisAngleDeg = 15.0;

bool IsInImage(const View& view, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector3d x = view.cam_from_world * x_in_world;
  return x.z() > 0 && view.camera.Contains(view.camera.Project(x));
}

}  // namespace

SameSights::SameSights(const Scene& scene, double min_angle_deg)
    : scene_(scene), min_angle_deg_(min_angle_deg), groups_(CenterGroups(scene)) {
  for (const View& view : scene.views) centers_.push_back(view.CenterInWorld());
}

bool SameSights::ShowTheSame(std::span<const Eigen::Vector3d> places, int view_idx,
                             int other_idx) const {
  const auto v = static_cast<size_t>(view_idx), o = static_cast<size_t>(other_idx);
  const View &view = scene_.views[v], &other = scene_.views[o];
  const double scale = view.camera.MeanFocalLength() / other.camera.MeanFocalLength();
  if (std::max(scale, 1 / scale) > kMaxScaleRatio) return false;
  if (places.empty()) return groups_[v] == groups_[o] && LookTheSameWay(view, other);
  size_t num_seen = 0, num_shared = 0, num_same_side = 0;
  for (const Eigen::Vector3d& x : places) {
    if (!IsInImage(view, x)) continue;
    ++num_seen;
    if (!IsInImage(other, x)) continue;
    ++num_shared;
    num_same_side +=
        TriangulationAngle(centers_[v], centers_[o], x) < kRadiansPerDegree * min_angle_deg_;
  }
  return num_seen > 0 &&
         static_cast<double>(num_shared) >= kMinSharedPart * static_cast<double>(num_seen) &&
         2 * num_same_side > num_shared;
}

bool SameSights::LookTheSameWay(const View& view, const View& other) const {
  const double cosine =
      view.cam_from_world.rotation.row(2).dot(other.cam_from_world.rotation.row(2));
  return cosine >= std::cos(kRadiansPerDegree * kMaxAxisAngleDeg);
}

}  // namespace lsmvs
