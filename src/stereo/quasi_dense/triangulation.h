#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"

namespace lsmvs::quasi_dense {

using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;
ProjectionMatrix MakeProjectionMatrix(const Rigid3& cam_from_world, const PinholeCamera& camera);

// A point seen by a view.
struct Observation {
  const ProjectionMatrix* projection = nullptr;
  Eigen::Vector2d x_px = Eigen::Vector2d::Zero();
};

// Reprojection error in pixels; infinite for a point behind the camera.
double ReprojectionError(const Observation& observation, const Eigen::Vector3d& x_in_world);

// Value and derivative by the squared error of the factor that turns a residual r into one whose
// square is the Cauchy loss of |r|^2: sqrt(rho(s) / s) with rho(s) = c^2 log(1 + s / c^2).
struct RobustFactor {
  double value = 1, derivative = 0;
};
RobustFactor CauchyFactor(double squared_error, double loss_scale);

// Moves a point to the minimum of the Cauchy losses of its reprojection errors, cameras fixed, by
// Ceres' Levenberg-Marquardt solver for tiny problems (ceres::TinySolver: no allocation once warm,
// a few microseconds a point, where ceres::Problem takes a hundred). Lengths are measured in
// `unit` (a pixel on the surface, world units), so that the result does not depend on the scene's
// unit. Not thread-safe: one a thread.
class PointOptimizer {
 public:
  explicit PointOptimizer(double loss_scale_px);
  ~PointOptimizer();
  // Empty if the minimum found is behind a camera or not finite.
  std::optional<Eigen::Vector3d> Optimize(std::span<const Observation> observations,
                                          const Eigen::Vector3d& start, double unit);

 private:
  struct Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace lsmvs::quasi_dense
