#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace lsmvs::internal {

// The weighted sum of squared distances to planes, x^T A x + 2 b^T x + c.
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0;

  void AddPlane(const Eigen::Vector3d& normal, const Eigen::Vector3d& x, double weight) {
    const double offset = -normal.dot(x);
    a += weight * normal * normal.transpose();
    b += weight * offset * normal;
    c += weight * offset * offset;
  }
  Quadric& operator+=(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    return *this;
  }
  double At(const Eigen::Vector3d& x) const {
    return std::max(0.0, x.dot(a * x) + 2 * b.dot(x) + c);
  }
};

}  // namespace lsmvs::internal
