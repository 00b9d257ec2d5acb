#include "lsmvs/scene/depth_normals.h"

#include <Eigen/Dense>
#include <cmath>

namespace lsmvs {

namespace {

constexpr int kRadius = 2;
constexpr double kMaxRelativeStep = 0.02;
constexpr int kMinSamples = 6;
// Below this the samples lie on a line.
constexpr double kMinDeterminant = 1e-9;

// n with n . ray = 1 / depth for all rays of the plane through the samples; zero if there is none.
Eigen::Vector3d FitInverseDepth(const Raster<float>& depth, const PinholeCamera& camera,
                                double sample_px, int column, int row) {
  const double middle = 1.0 / depth(column, row);
  // In pixels from the middle, for a well-conditioned sum: inverse depth = a dx + b dy + c.
  Eigen::Matrix3d sums = Eigen::Matrix3d::Zero();
  Eigen::Vector3d values = Eigen::Vector3d::Zero();
  int count = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      if (!depth.Inside(column + dx, row + dy)) continue;
      const double sample = depth(column + dx, row + dy);
      if (!(sample > 0) || std::abs(1 / sample - middle) > kMaxRelativeStep * middle) continue;
      const Eigen::Vector3d x(dx, dy, 1);
      sums += x * x.transpose();
      values += x / sample;
      ++count;
    }
  }
  if (count < kMinSamples || sums.determinant() < kMinDeterminant) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d fit = sums.ldlt().solve(values);
  const double a = fit.x() * camera.fx, b = fit.y() * camera.fy;
  const Eigen::Vector3d ray = camera.Ray(Eigen::Vector2d(column + sample_px, row + sample_px));
  return {a, b, fit.z() - a * ray.x() - b * ray.y()};
}

}  // namespace

Raster<Eigen::Vector3f> NormalsFromDepth(const Raster<float>& depth, const PinholeCamera& camera,
                                         double sample_px) {
  Raster<Eigen::Vector3f> normals(depth.width, depth.height, Eigen::Vector3f::Zero());
  for (int row = 0; row < depth.height; ++row) {
    for (int column = 0; column < depth.width; ++column) {
      if (!(depth(column, row) > 0)) continue;
      const Eigen::Vector3d away = FitInverseDepth(depth, camera, sample_px, column, row);
      if (away.z() > 0) normals(column, row) = (-away.normalized()).cast<float>();
    }
  }
  return normals;
}

}  // namespace lsmvs
