#pragma once

#include <Eigen/Core>

namespace lsmvs {

// Ideal pinhole camera without distortion.
//
// Conventions, for the whole project: image coordinates (x, y) in pixels, x right and y down; the
// centre of the top-left pixel is (0.5, 0.5) and the image covers [0,width] x [0,height]. Pixel
// (column, row) has its centre at (column + 0.5, row + 0.5). In the camera frame z looks forward;
// "depth" is z, not the distance to the centre.
struct PinholeCamera {
  int width = 0, height = 0;  // pixels
  double fx = 0, fy = 0;      // focal lengths, pixels
  double cx = 0, cy = 0;      // principal point, pixels

  // Image coordinates of a point in the camera frame; its z must not be 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_cam) const {
    return {fx * x_in_cam.x() / x_in_cam.z() + cx, fy * x_in_cam.y() / x_in_cam.z() + cy};
  }
  // The point of the ray through `x_px` that has depth 1; times d it has depth d.
  Eigen::Vector3d Ray(const Eigen::Vector2d& x_px) const {
    return {(x_px.x() - cx) / fx, (x_px.y() - cy) / fy, 1.0};
  }
  Eigen::Vector3d PixelRay(int column, int row) const { return Ray({column + 0.5, row + 0.5}); }
  bool Contains(const Eigen::Vector2d& x_px) const {
    return x_px.x() >= 0 && x_px.y() >= 0 && x_px.x() < width && x_px.y() < height;
  }
  Eigen::Matrix3d Matrix() const;
  // The same camera with an image of another size: both cover the same field of view exactly.
  PinholeCamera Resized(int new_width, int new_height) const;
  // Mean focal length; one pixel covers about depth / MeanFocalLength() on a surface that faces the
  // camera.
  double MeanFocalLength() const { return 0.5 * (fx + fy); }
};

}  // namespace lsmvs
