#include "lsmvs/stereo/quasi_dense/triangulation.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs::quasi_dense {
namespace {

constexpr double kLossScale = 0.5;

// Views around a point, scaled by `scale`.
struct Views {
  explicit Views(int count, double scale = 1) : unit(scale * 3 / camera.MeanFocalLength()) {
    for (const Eigen::Vector3d& center : RingCenters({0, 0, 0}, 3 * scale, scale, count, 0, 60)) {
      projections.push_back(MakeProjectionMatrix(LookAt(center, {0, 0, 0}), camera));
    }
  }
  std::vector<Observation> Observe(const Eigen::Vector3d& x, double noise_px, uint64_t seed) const {
    Random random(seed);
    std::vector<Observation> observations;
    for (const ProjectionMatrix& projection : projections) {
      const Eigen::Vector3d h = projection * x.homogeneous();
      const double dx = noise_px * random.Gaussian(), dy = noise_px * random.Gaussian();
      observations.push_back({&projection, h.head<2>() / h.z() + Eigen::Vector2d(dx, dy)});
    }
    return observations;
  }

  PinholeCamera camera = MakeCamera(1000, 800);
  std::vector<ProjectionMatrix> projections;
  double unit;  // a pixel on the surface
};

// The same problem put to Ceres' large solver with its own loss and numeric derivatives.
struct ReprojectionCost {
  const Observation& observation;
  bool operator()(const double* point, double* residual) const {
    const Eigen::Vector3d x(point[0], point[1], point[2]);
    const Eigen::Vector3d h = *observation.projection * x.homogeneous();
    residual[0] = h.x() / h.z() - observation.x_px.x();
    residual[1] = h.y() / h.z() - observation.x_px.y();
    return true;
  }
};

Eigen::Vector3d SolveWithCeres(const std::vector<Observation>& observations, Eigen::Vector3d x) {
  ceres::Problem problem;
  for (const Observation& observation : observations) {
    problem.AddResidualBlock(
        new ceres::NumericDiffCostFunction<ReprojectionCost, ceres::CENTRAL, 2, 3>(
            new ReprojectionCost{observation}),
        new ceres::CauchyLoss(kLossScale), x.data());
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return x;
}

TEST(QuasiDenseTriangulation, RobustFactorIsThatOfTheCauchyLoss) {
  const ceres::CauchyLoss loss(kLossScale);
  for (const double squared : {1e-9, 1e-4, 2.4e-4, 2.6e-4, 0.01, 0.25, 1.0, 100.0, 1e6}) {
    double rho[3];
    loss.Evaluate(squared, rho);
    const RobustFactor factor = CauchyFactor(squared, kLossScale);
    EXPECT_NEAR(factor.value * factor.value * squared, rho[0], 1e-7 * rho[0]);
    const double h = 1e-4 * squared;
    const double difference = (CauchyFactor(squared + h, kLossScale).value -
                               CauchyFactor(squared - h, kLossScale).value) /
                              (2 * h);
    if (squared > 1e-3) {
      EXPECT_NEAR(factor.derivative, difference, 1e-5 * std::abs(difference) + 1e-12);
    }
  }
  EXPECT_EQ(CauchyFactor(0, kLossScale).value, 1);
  EXPECT_NEAR(CauchyFactor(0, kLossScale).derivative, -0.25 / (kLossScale * kLossScale), 1e-12);
}

TEST(QuasiDenseTriangulation, ExactWithoutNoise) {
  const Views views(5);
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const auto observations = views.Observe(truth, 0, 1);
  PointOptimizer optimizer(kLossScale);
  const auto x =
      optimizer.Optimize(observations, truth + Eigen::Vector3d(0.003, -0.002, 0.004), views.unit);
  ASSERT_TRUE(x.has_value());
  EXPECT_LT((*x - truth).norm(), 1e-5 * views.unit);
}

TEST(QuasiDenseTriangulation, AgreesWithCeres) {
  PointOptimizer optimizer(kLossScale);
  Random random(3);
  for (uint64_t trial = 0; trial < 50; ++trial) {
    const Views views(2 + static_cast<int>(random.Below(7)));
    const Eigen::Vector3d truth = 0.2 * random.Gaussian3();
    auto observations = views.Observe(truth, 0.3, trial);
    if (trial % 2 == 0 && observations.size() > 3) observations[1].x_px.x() += 3;
    const Eigen::Vector3d start = truth + 2 * views.unit * random.Gaussian3();
    const auto x = optimizer.Optimize(observations, start, views.unit);
    ASSERT_TRUE(x.has_value());
    // From the same place: the loss may have several minima.
    EXPECT_LT((*x - SolveWithCeres(observations, *x)).norm(), 5e-3 * views.unit);
  }
}

TEST(QuasiDenseTriangulation, AnOutlierDoesNotPull) {
  const Views views(8);
  const Eigen::Vector3d truth(0, 0.1, 0);
  auto observations = views.Observe(truth, 0.1, 5);
  observations[3].x_px += Eigen::Vector2d(2.5, -1.5);
  PointOptimizer optimizer(kLossScale);
  const auto x = optimizer.Optimize(observations, truth, views.unit);
  ASSERT_TRUE(x.has_value());
  EXPECT_LT((*x - truth).norm(), 0.35 * views.unit);
  EXPECT_GT(ReprojectionError(observations[3], *x), 2.5);
}

TEST(QuasiDenseTriangulation, DoesNotDependOnTheUnit) {
  PointOptimizer optimizer(kLossScale);
  const Views small(5, 1), large(5, 1000);
  const Eigen::Vector3d truth(0.1, 0.2, -0.1);
  const auto a = optimizer.Optimize(small.Observe(truth, 0.3, 9), truth, small.unit);
  const auto b = optimizer.Optimize(large.Observe(1000 * truth, 0.3, 9), 1000 * truth, large.unit);
  ASSERT_TRUE(a && b);
  EXPECT_LT((*b / 1000 - *a).norm(), 1e-6 * small.unit);
}

TEST(QuasiDenseTriangulation, RefusesPointsBehindACamera) {
  const Views views(3);
  PointOptimizer optimizer(kLossScale);
  const auto observations = views.Observe({0, 0, 0}, 0, 1);
  EXPECT_TRUE(std::isinf(ReprojectionError(observations[0], {30, 0, 0})));
  // Observations that only a point behind the cameras explains.
  const auto behind = views.Observe({30, 8, 3}, 0, 1);
  const auto x = optimizer.Optimize(behind, {30, 8, 3}, views.unit);
  EXPECT_FALSE(x.has_value());
}

}  // namespace
}  // namespace lsmvs::quasi_dense
