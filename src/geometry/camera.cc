#include "lsmvs/geometry/camera.h"

namespace lsmvs {

Eigen::Matrix3d PinholeCamera::Matrix() const {
  Eigen::Matrix3d matrix;
  matrix << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return matrix;
}

PinholeCamera PinholeCamera::Resized(int new_width, int new_height) const {
  const double scale_x = static_cast<double>(new_width) / width;
  const double scale_y = static_cast<double>(new_height) / height;
  return {new_width, new_height, fx * scale_x, fy * scale_y, cx * scale_x, cy * scale_y};
}

}  // namespace lsmvs
