#include "lsmvs/synthetic/cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lsmvs {

PinholeCamera MakeCamera(int width, int height, double focal_factor) {
  const double focal = focal_factor * std::max(width, height);
  return {width, height, focal, focal, 0.5 * width, 0.5 * height};
}

Rigid3 LookAt(const Eigen::Vector3d& center, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - center).normalized();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  constexpr double kNearlyVertical = 0.35;  // sine of 20 degrees
  if (forward.cross(up).norm() < kNearlyVertical) up = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  Eigen::Matrix3d rotation;
  rotation.row(0) = right;
  rotation.row(1) = forward.cross(right);
  rotation.row(2) = forward;
  return Rigid3(rotation, Eigen::Vector3d(-(rotation * center)));
}

View MakeView(int index, const PinholeCamera& camera, const Rigid3& cam_from_world) {
  View view;
  view.image_id = static_cast<ImageId>(index + 1);
  view.name = fmt::format("{:04}.png", index);
  view.camera = camera;
  view.cam_from_world = cam_from_world;
  return view;
}

std::vector<Eigen::Vector3d> RingCenters(const Eigen::Vector3d& target, double radius,
                                         double height, int count, double begin_deg,
                                         double sweep_deg) {
  const bool closed = sweep_deg >= 360.0;
  const int gaps = closed ? count : std::max(1, count - 1);
  std::vector<Eigen::Vector3d> centers;
  for (int i = 0; i < count; ++i) {
    const double angle = (begin_deg + sweep_deg * i / gaps) * std::numbers::pi / 180.0;
    centers.push_back(target +
                      Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), height));
  }
  return centers;
}

std::vector<Eigen::Vector3d> GridCenters(double half_x, double half_y, double z, int columns,
                                         int rows) {
  const auto spread = [](double half, int i, int count) {
    return count == 1 ? 0.0 : half * (2.0 * i / (count - 1) - 1.0);
  };
  std::vector<Eigen::Vector3d> centers;
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < columns; ++i) {
      const int column = row % 2 == 0 ? i : columns - 1 - i;
      centers.emplace_back(spread(half_x, column, columns), spread(half_y, row, rows), z);
    }
  }
  return centers;
}

}  // namespace lsmvs
