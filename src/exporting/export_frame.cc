#include "lsmvs/exporting/export_frame.h"

#include <Eigen/Geometry>

namespace lsmvs {

namespace {

// Single precision is 6e-8 of the coordinate.
constexpr double kLargestShare = 16;

}  // namespace

Eigen::Matrix3d YUpFromWorld(const ExportDirections& directions) {
  const Eigen::Vector3d up = directions.up.normalized();
  Eigen::Vector3d viewer = directions.to_viewer - directions.to_viewer.dot(up) * up;
  if (viewer.norm() <= 1e-6 * directions.to_viewer.norm()) viewer = up.unitOrthogonal();
  viewer.normalize();
  Eigen::Matrix3d rotation;
  rotation.row(0) = up.cross(viewer);
  rotation.row(1) = up;
  rotation.row(2) = viewer;
  return rotation;
}

Eigen::Matrix3d ZUpFromWorld(const ExportDirections& directions) {
  const Eigen::Matrix3d y_up = YUpFromWorld(directions);
  Eigen::Matrix3d rotation;
  rotation.row(0) = y_up.row(0);
  rotation.row(1) = -y_up.row(2);
  rotation.row(2) = y_up.row(1);
  return rotation;
}

Eigen::Vector3d ExportOffset(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : mesh.vertices) box.extend(x);
  if (box.isEmpty()) return Eigen::Vector3d::Zero();
  const double largest = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
  if (largest <= kLargestShare * box.diagonal().norm()) return Eigen::Vector3d::Zero();
  return box.center().array().round();
}

}  // namespace lsmvs
