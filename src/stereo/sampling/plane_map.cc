#include "lsmvs/stereo/sampling/plane_map.h"

#include <algorithm>
#include <cmath>

namespace lsmvs {

Plane PlaneFromDepth(const PinholeCamera& camera, const Eigen::Vector2d& x_px, double depth,
                     const Eigen::Vector3d& normal) {
  if (!(depth > 0)) return {};
  const double along_ray = normal.dot(camera.Ray(x_px));
  const float q = static_cast<float>(1.0 / depth);
  if (!(along_ray < 0)) return {q, 0, 0};
  const double scale = 1.0 / (along_ray * depth);
  return {q, static_cast<float>(normal.x() * scale / camera.fx),
          static_cast<float>(normal.y() * scale / camera.fy)};
}

Eigen::Vector3f PlaneNormal(const PinholeCamera& camera, const Eigen::Vector2d& x_px,
                            const Plane& plane) {
  const double qx = plane.qx, qy = plane.qy;
  const double q_at_principal_point =
      plane.q + qx * (camera.cx - x_px.x()) + qy * (camera.cy - x_px.y());
  const Eigen::Vector3d away(camera.fx * qx, camera.fy * qy, q_at_principal_point);
  return (-away.normalized()).cast<float>();
}

PlaneMap ToPlaneMap(const PinholeCamera& camera, const DepthMap& map) {
  PlaneMap planes(map.depth.width, map.depth.height);
  for (int row = 0; row < planes.height; ++row) {
    for (int column = 0; column < planes.width; ++column) {
      planes(column, row) =
          PlaneFromDepth(camera, {column + 0.5, row + 0.5}, map.depth(column, row),
                         map.normal(column, row).cast<double>());
    }
  }
  return planes;
}

DepthMap ToDepthMap(const PinholeCamera& camera, const PlaneMap& planes) {
  DepthMap map{Raster<float>(planes.width, planes.height, 0.0f),
               Raster<Eigen::Vector3f>(planes.width, planes.height, Eigen::Vector3f::Zero())};
  for (int row = 0; row < planes.height; ++row) {
    for (int column = 0; column < planes.width; ++column) {
      const Plane& plane = planes(column, row);
      if (!(plane.q > 0)) continue;
      map.depth(column, row) = 1.0f / plane.q;
      map.normal(column, row) = PlaneNormal(camera, {column + 0.5, row + 0.5}, plane);
    }
  }
  return map;
}

PlaneMap ResizePlaneMap(const PlaneMap& planes, int width, int height) {
  PlaneMap resized(width, height);
  const float scale_x = static_cast<float>(planes.width) / static_cast<float>(width);
  const float scale_y = static_cast<float>(planes.height) / static_cast<float>(height);
  for (int row = 0; row < height; ++row) {
    const float y = (static_cast<float>(row) + 0.5f) * scale_y;
    const int from_row = std::min(static_cast<int>(y), planes.height - 1);
    for (int column = 0; column < width; ++column) {
      const float x = (static_cast<float>(column) + 0.5f) * scale_x;
      const int from_column = std::min(static_cast<int>(x), planes.width - 1);
      Plane plane = planes(from_column, from_row)
                        .Moved(x - (static_cast<float>(from_column) + 0.5f),
                               y - (static_cast<float>(from_row) + 0.5f));
      plane.qx *= scale_x;
      plane.qy *= scale_y;
      if (!(planes(from_column, from_row).q > 0) || !(plane.q > 0)) plane = {};
      resized(column, row) = plane;
    }
  }
  return resized;
}

}  // namespace lsmvs
