#include "lsmvs/geometry/triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

double SumOfSquaredDistances(const std::vector<ViewingRay>& rays, const Eigen::Vector3d& x) {
  double sum = 0;
  for (const ViewingRay& ray : rays) {
    sum += ray.direction.cross(x - ray.origin).squaredNorm();
  }
  return sum;
}

std::vector<ViewingRay> RaysTo(const Eigen::Vector3d& x, double noise, int count, Random* random) {
  std::vector<ViewingRay> rays;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d origin = x + 5.0 * random->Gaussian3();
    const Eigen::Vector3d target = x + noise * random->Gaussian3();
    rays.push_back({origin, (target - origin).normalized()});
  }
  return rays;
}

TEST(TriangulationAngle, IsExactAtAllAngles) {
  const Eigen::Vector3d x(1, 2, 3);
  for (const double angle : {0.0, 1e-9, 1e-4, 0.3, 1.5, 3.0, std::numbers::pi}) {
    const Eigen::Vector3d a = x + Eigen::Vector3d(2, 0, 0);
    const Eigen::Vector3d b = x + 0.7 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    EXPECT_NEAR(TriangulationAngle(a, b, x), angle, 1e-15 + 1e-7 * angle);
  }
}

TEST(TriangulateRays, MeetsThePointThatAllRaysGoThrough) {
  Random random(3);
  for (const int count : {2, 3, 10}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d x = 3 * random.Gaussian3();
      const auto found = TriangulateRays(RaysTo(x, 0.0, count, &random));
      ASSERT_TRUE(found);
      EXPECT_LT((*found - x).norm(), 1e-9);
    }
  }
}

TEST(TriangulateRays, MinimisesTheSumOfSquaredDistances) {
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const auto rays = RaysTo(random.Gaussian3(), 0.1, 4, &random);
    const auto found = TriangulateRays(rays);
    ASSERT_TRUE(found);
    const double least = SumOfSquaredDistances(rays, *found);
    for (int k = 0; k < 10; ++k) {
      EXPECT_GE(SumOfSquaredDistances(rays, *found + 1e-3 * random.Gaussian3()), least);
    }
  }
}

TEST(TriangulateRays, TwoRaysMeetInTheMiddleOfTheirShortestConnection) {
  const std::vector<ViewingRay> rays = {{{-1, 0, 0}, {1, 0, 0}}, {{0, -1, 0.2}, {0, 1, 0}}};
  const auto found = TriangulateRays(rays);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - Eigen::Vector3d(0, 0, 0.1)).norm(), 1e-12);
}

TEST(TriangulateRays, KeepsItsDigitsFarFromTheOrigin) {
  Random random(5);
  const Eigen::Vector3d far(431000.0, 5411000.0, 200.0);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d x = far + random.Gaussian3();
    const auto found = TriangulateRays(RaysTo(x, 0.0, 3, &random));
    ASSERT_TRUE(found);
    EXPECT_LT((*found - x).norm(), 1e-7);
  }
}

TEST(TriangulateRays, ParallelRaysGiveNothing) {
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, 3).normalized();
  EXPECT_FALSE(TriangulateRays({{{0, 0, 0}, direction}, {{1, 0, 0}, direction}}));
  EXPECT_FALSE(TriangulateRays({{{0, 0, 0}, direction}, {{1, 0, 0}, -direction}}));
  const double angle = 1e-8;
  EXPECT_FALSE(TriangulateRays(
      {{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 0}, {std::cos(angle), std::sin(angle), 0}}}));
  EXPECT_FALSE(TriangulateRays({{{0, 0, 0}, {std::nan(""), 0, 0}}, {{0, 1, 0}, {1, 0, 0}}}));
}

TEST(TriangulateRays, SmallAnglesStillWork) {
  const double angle = 1e-4;
  const auto found = TriangulateRays(
      {{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 0}, {std::cos(angle), -std::sin(angle), 0}}});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->x(), 1 / std::tan(angle), 1.0);
}

TEST(TriangulateRays, OneRayIsAMistake) {
  EXPECT_THROW(TriangulateRays({{{0, 0, 0}, {1, 0, 0}}}), std::logic_error);
}

}  // namespace
}  // namespace lsmvs
