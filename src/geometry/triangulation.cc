#include "lsmvs/geometry/triangulation.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "lsmvs/util/check.h"

namespace lsmvs {

double TriangulationAngle(const Eigen::Vector3d& center_a, const Eigen::Vector3d& center_b,
                          const Eigen::Vector3d& x) {
  const Eigen::Vector3d a = center_a - x, b = center_b - x;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

std::optional<Eigen::Vector3d> TriangulateRays(const std::vector<ViewingRay>& rays) {
  LSMVS_CHECK_GE(rays.size(), size_t{2});
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  // Relative to the first origin, so that far-away world frames lose no digits.
  const Eigen::Vector3d shift = rays.front().origin;
  for (const ViewingRay& ray : rays) {
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - ray.direction * ray.direction.transpose();
    normal_matrix += across;
    right_side += across * (ray.origin - shift);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal_matrix);
  // The smallest eigenvalue is about n * sin^2(angle) / 2: below 1e-12 the angle is under a
  // microradian.
  if (!(eigen.eigenvalues()(0) > 1e-12 * static_cast<double>(rays.size()))) return std::nullopt;
  return shift + eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                     eigen.eigenvectors().transpose() * right_side;
}

}  // namespace lsmvs
