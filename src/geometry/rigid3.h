#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace lsmvs {

// Rigid transform b_from_a: x_in_b = rotation * x_in_a + translation.
struct Rigid3 {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Rigid3() = default;
  Rigid3(const Eigen::Matrix3d& b_from_a_rotation, const Eigen::Vector3d& b_from_a_translation)
      : rotation(b_from_a_rotation), translation(b_from_a_translation) {}
  // `b_from_a` need not be of unit length, but not zero.
  Rigid3(const Eigen::Quaterniond& b_from_a, const Eigen::Vector3d& b_from_a_translation)
      : rotation(b_from_a.normalized().toRotationMatrix()), translation(b_from_a_translation) {}

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_a) const {
    return rotation * x_in_a + translation;
  }
  Rigid3 Inverse() const {
    return Rigid3(Eigen::Matrix3d(rotation.transpose()), -(rotation.transpose() * translation));
  }
  // Where b's origin lies in a: for a cam_from_world this is the projection centre in the world.
  Eigen::Vector3d OriginInSource() const { return -(rotation.transpose() * translation); }
};

// c_from_a = c_from_b * b_from_a.
inline Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a) {
  return Rigid3(Eigen::Matrix3d(c_from_b.rotation * b_from_a.rotation),
                c_from_b.rotation * b_from_a.translation + c_from_b.translation);
}

}  // namespace lsmvs
