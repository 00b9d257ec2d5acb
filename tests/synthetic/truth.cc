#include "lsmvs/synthetic/truth.h"

#include <cmath>
#include <numbers>

namespace lsmvs {

namespace {

constexpr size_t kRowsPerBlock = 4;
// Relative slack of the occlusion test: far above rounding, far below any feature.
constexpr double kOcclusionSlack = 1e-6;

void FillPixel(const Shape& shape, const Eigen::Vector3d& center, const Eigen::Matrix3d& rotation,
               const Eigen::Vector3d& ray_in_cam, float* depth, Eigen::Vector3f* normal) {
  const double length = ray_in_cam.norm();
  const Eigen::Vector3d direction = rotation.transpose() * (ray_in_cam / length);
  const std::optional<RayHit> hit = shape.Intersect(center, direction);
  *depth = hit ? static_cast<float>(hit->distance / length) : 0.0f;
  *normal = hit ? Eigen::Vector3f((rotation * hit->normal).cast<float>())
                : Eigen::Vector3f(Eigen::Vector3f::Zero());
}

}  // namespace

DepthMap TrueDepthMap(const Shape& shape, const View& view, int width, int height,
                      const RunContext& context) {
  const PinholeCamera camera = view.camera.Resized(width, height);
  const Eigen::Vector3d center = view.CenterInWorld();
  DepthMap map{Raster<float>(width, height), Raster<Eigen::Vector3f>(width, height)};
  ParallelFor(context, static_cast<size_t>(height), kRowsPerBlock, [&](size_t row_index) {
    const int row = static_cast<int>(row_index);
    for (int column = 0; column < width; ++column) {
      FillPixel(shape, center, view.cam_from_world.rotation, camera.PixelRay(column, row),
                &map.depth(column, row), &map.normal(column, row));
    }
  });
  return map;
}

DepthMap TrueDepthMap(const Shape& shape, const View& view, const RunContext& context) {
  return TrueDepthMap(shape, view, view.camera.width, view.camera.height, context);
}

bool SeesSurfacePoint(const Shape& shape, const View& view, const Eigen::Vector3d& x_in_world,
                      const Eigen::Vector3d& normal, double max_angle_deg) {
  if (!(view.Depth(x_in_world) > 0)) return false;
  if (!view.camera.Contains(view.camera.Project(view.cam_from_world * x_in_world))) return false;
  const Eigen::Vector3d center = view.CenterInWorld();
  const double distance = (x_in_world - center).norm();
  const Eigen::Vector3d direction = (x_in_world - center) / distance;
  if (-direction.dot(normal) < std::cos(max_angle_deg * std::numbers::pi / 180.0)) return false;
  const std::optional<RayHit> hit = shape.Intersect(center, direction);
  return !hit || hit->distance >= distance * (1 - kOcclusionSlack);
}

MemoryDepthMaps::MemoryDepthMaps(std::vector<DepthMap> maps) {
  for (DepthMap& map : maps) maps_.push_back(std::make_shared<DepthMap>(std::move(map)));
}

std::shared_ptr<const DepthMap> MemoryDepthMaps::Get(int view_idx) const {
  return maps_[static_cast<size_t>(view_idx)];
}

}  // namespace lsmvs
