#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"

namespace lsmvs {

// How a chart lays the surface out flat: as a photo shows it, or, for what no photo shows, along an
// axis of the world. Coordinates are in texels, x right and y down, before the chart is moved to
// its place on a page.
class ChartMap {
 public:
  ChartMap() = default;
  // `scale`: texels per pixel of the photo.
  static ChartMap OfPhoto(const PinholeCamera& camera, const Rigid3& cam_from_world, double scale) {
    ChartMap map;
    map.is_photo_ = true;
    map.camera_ = camera;
    map.cam_from_world_ = cam_from_world;
    map.scale_ = scale;
    return map;
  }
  // `axis` 0 .. 2, looked along from its positive or negative end; `scale`: texels per world unit.
  static ChartMap OfAxis(int axis, bool from_positive, double scale) {
    ChartMap map;
    map.across_ = {(axis + 1) % 3, (axis + 2) % 3};
    if (!from_positive) std::swap(map.across_[0], map.across_[1]);
    map.scale_ = scale;
    return map;
  }

  Eigen::Vector2d operator()(const Eigen::Vector3d& x_in_world) const {
    if (is_photo_) return scale_ * camera_.Project(cam_from_world_ * x_in_world);
    return scale_ * Eigen::Vector2d(x_in_world[across_[0]], -x_in_world[across_[1]]);
  }

 private:
  bool is_photo_ = false;
  PinholeCamera camera_;
  Rigid3 cam_from_world_;
  std::array<int, 2> across_ = {0, 1};
  double scale_ = 1;
};

}  // namespace lsmvs
