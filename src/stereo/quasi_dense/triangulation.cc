#include <ceres/tiny_solver.h>

#include <cmath>
#include <limits>

#include "lsmvs/stereo/quasi_dense/triangulation.h"

namespace lsmvs::quasi_dense {

namespace {

// Residuals of all observations as a function of the point's offset from `start` in units.
struct ReprojectionFunction {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 3 };

  std::span<const Observation> observations;
  Eigen::Vector3d start;
  double unit;
  double loss_scale;

  int NumResiduals() const { return 2 * static_cast<int>(observations.size()); }

  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    const Eigen::Vector3d x = start + unit * Eigen::Map<const Eigen::Vector3d>(parameters);
    for (size_t k = 0; k < observations.size(); ++k) {
      Evaluate(observations[k], x, static_cast<Eigen::Index>(2 * k), residuals, jacobian);
    }
    return true;
  }

  void Evaluate(const Observation& observation, const Eigen::Vector3d& x, Eigen::Index row,
                double* residuals, double* jacobian) const {
    const ProjectionMatrix& projection = *observation.projection;
    const Eigen::Vector3d h = projection * x.homogeneous();
    const Eigen::Vector2d image = h.head<2>() / h.z();
    const Eigen::Vector2d residual = image - observation.x_px;
    const RobustFactor factor = CauchyFactor(residual.squaredNorm(), loss_scale);
    Eigen::Map<Eigen::Vector2d>(residuals + row) = factor.value * residual;
    if (jacobian == nullptr) return;
    const Eigen::Matrix<double, 2, 3> by_point =
        (projection.topLeftCorner<2, 3>() - image * projection.bottomLeftCorner<1, 3>()) *
        (unit / h.z());
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3>>(jacobian, NumResiduals(), 3)
        .middleRows<2>(row) =
        factor.value * by_point +
        residual * (2 * factor.derivative * (residual.transpose() * by_point));
  }
};

}  // namespace

ProjectionMatrix MakeProjectionMatrix(const Rigid3& cam_from_world, const PinholeCamera& camera) {
  ProjectionMatrix pose;
  pose << cam_from_world.rotation, cam_from_world.translation;
  return camera.Matrix() * pose;
}

double ReprojectionError(const Observation& observation, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector3d h = *observation.projection * x_in_world.homogeneous();
  if (!(h.z() > 0)) return std::numeric_limits<double>::infinity();
  return (h.head<2>() / h.z() - observation.x_px).norm();
}

RobustFactor CauchyFactor(double squared_error, double loss_scale) {
  const double squared_scale = loss_scale * loss_scale;
  const double t = squared_error / squared_scale;
  // Series where the quotients below would lose their digits.
  if (t < 1e-3) {
    return {1 - t / 4 + t * t * 13 / 96, (-0.25 + t * 13 / 48) / squared_scale};
  }
  const double log_over_t = std::log1p(t) / t;
  const double value = std::sqrt(log_over_t);
  return {value, (1 / (1 + t) - log_over_t) / (2 * t * value) / squared_scale};
}

struct PointOptimizer::Solver {
  double loss_scale_px;
  ceres::TinySolver<ReprojectionFunction> tiny;
};

PointOptimizer::PointOptimizer(double loss_scale_px) : solver_(std::make_unique<Solver>()) {
  solver_->loss_scale_px = loss_scale_px;
  auto& options = solver_->tiny.options;
  options.max_num_iterations = 50;
  options.gradient_tolerance = 1e-8;
  options.parameter_tolerance = 1e-6;
  options.function_tolerance = 1e-10;
  options.cost_threshold = 1e-14;
}

PointOptimizer::~PointOptimizer() = default;

std::optional<Eigen::Vector3d> PointOptimizer::Optimize(std::span<const Observation> observations,
                                                        const Eigen::Vector3d& start, double unit) {
  const ReprojectionFunction function{observations, start, unit, solver_->loss_scale_px};
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  solver_->tiny.Solve(function, &offset);
  const Eigen::Vector3d x = start + unit * offset;
  if (!x.allFinite()) return std::nullopt;
  for (const Observation& observation : observations) {
    if (!(observation.projection->row(2).dot(x.homogeneous()) > 0)) return std::nullopt;
  }
  return x;
}

}  // namespace lsmvs::quasi_dense
