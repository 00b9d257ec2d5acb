#include "lsmvs/evaluation/samples/closest_points.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace lsmvs {
namespace {

TEST(ClosestPoints, AgreesWithBruteForce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] {
    return Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
  };
  std::vector<Eigen::Vector3d> points(500);
  for (Eigen::Vector3d& x : points) x = point();
  const ClosestPoints closest(points);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d query = 2 * point();
    double best = 10;
    for (const Eigen::Vector3d& x : points) best = std::min(best, (x - query).norm());
    EXPECT_NEAR(closest.Distance(query, 10), best, 1e-12);
  }
}

TEST(ClosestPoints, StopsAtTheMaximum) {
  EXPECT_EQ(ClosestPoints({{0, 0, 0}}).Distance({3, 0, 0}, 2), 2);
  EXPECT_EQ(ClosestPoints({}).Distance({3, 0, 0}, 2), 2);
}

TEST(ClosestPoints, LeavesOutWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ClosestPoints({{nan, 0, 0}, {1, 0, 0}}).Distance({0, 0, 0}, 5), 1);
}

}  // namespace
}  // namespace lsmvs
