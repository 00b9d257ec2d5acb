#include "lsmvs/stereo/quasi_dense/pairs.h"

#include <gtest/gtest.h>

#include <vector>

#include "lsmvs/stereo/quasi_dense/planes.h"
#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs::quasi_dense {
namespace {

struct TwoViews {
  PinholeCamera camera_a = MakeCamera(640, 480), camera_b = MakeCamera(500, 400, 1.5);
  Rigid3 a = LookAt({0.2, -3, 0.1}, {0, 0, 0}), b = LookAt({1.1, -2.8, 0.4}, {0, 0.1, 0});
  InverseDepthTransferf geometry = MakePairTransfer(a, camera_a, b, camera_b);

  // Image in b of the pixel of a on the plane given at `origin`.
  Eigen::Vector2d Map(const Eigen::Vector2d& x_px, const Eigen::Vector2d& origin,
                      const Plane& plane) const {
    const double inverse_depth =
        plane.q + plane.qx * (x_px.x() - origin.x()) + plane.qy * (x_px.y() - origin.y());
    const Eigen::Vector3d x_in_world = a.Inverse() * (camera_a.Ray(x_px) / inverse_depth);
    return camera_b.Project(b * x_in_world);
  }
};

TEST(QuasiDensePairs, WarpsAsTheCamerasDo) {
  const TwoViews views;
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector2d center(random.Uniform(50, 590), random.Uniform(50, 430));
    const Plane plane{static_cast<float>(random.Uniform(0.25, 0.5)),
                      static_cast<float>(random.Uniform(-1e-3, 1e-3)),
                      static_cast<float>(random.Uniform(-1e-3, 1e-3))};
    PlaneWarp result;
    ASSERT_TRUE(WarpPlane(views.geometry, center.cast<float>(), plane, &result));
    const Eigen::Vector2d at = views.Map(center, center, plane);
    EXPECT_NEAR(result.warp.x, at.x(), 2e-3);
    EXPECT_NEAR(result.warp.y, at.y(), 2e-3);
    const double h = 1e-3;
    const Eigen::Vector2d by_x = (views.Map(center + Eigen::Vector2d(h, 0), center, plane) -
                                  views.Map(center - Eigen::Vector2d(h, 0), center, plane)) /
                                 (2 * h);
    const Eigen::Vector2d by_y = (views.Map(center + Eigen::Vector2d(0, h), center, plane) -
                                  views.Map(center - Eigen::Vector2d(0, h), center, plane)) /
                                 (2 * h);
    EXPECT_NEAR(result.warp.xx, by_x.x(), 1e-3);
    EXPECT_NEAR(result.warp.yx, by_x.y(), 1e-3);
    EXPECT_NEAR(result.warp.xy, by_y.x(), 1e-3);
    EXPECT_NEAR(result.warp.yy, by_y.y(), 1e-3);
    Plane nearer = plane, farther = plane;
    nearer.q += 1e-3f;
    farther.q -= 1e-3f;
    const Eigen::Vector2d velocity =
        (views.Map(center, center, nearer) - views.Map(center, center, farther)) /
        static_cast<double>(nearer.q - farther.q);
    EXPECT_LT((result.velocity.cast<double>() - velocity).norm(), 1e-2 * velocity.norm() + 1e-2);
  }
}

TEST(QuasiDensePairs, BehindTheOtherCameraIsNoImage) {
  // b looks away from what a sees.
  const PinholeCamera camera = MakeCamera(640, 480);
  const InverseDepthTransferf geometry = MakePairTransfer(LookAt({0, -3, 0}, {0, 0, 0}), camera,
                                                          LookAt({0, -3, 0}, {0, -6, 0}), camera);
  PlaneWarp result;
  EXPECT_FALSE(WarpPlane(geometry, {320, 240}, {0.3f, 0, 0}, &result));
}

TEST(QuasiDensePairs, PlanesMoveBetweenScales) {
  const Plane plane{0.5f, 1e-3f, -2e-3f};
  const Plane moved = MovePlane(plane, {3, -2}, {2, 2});
  EXPECT_FLOAT_EQ(moved.q, 0.5f + 3e-3f + 4e-3f);
  // One pixel of the finer scale is half a pixel of the coarser.
  EXPECT_FLOAT_EQ(moved.Moved(1, 0).q, plane.Moved(3.5f, -2).q);
  EXPECT_FLOAT_EQ(moved.Moved(0, 1).q, plane.Moved(3, -1.5f).q);
}

Neighbor To(int view_idx) {
  Neighbor neighbor;
  neighbor.view_idx = view_idx;
  return neighbor;
}

TEST(QuasiDensePairs, NeighborsAreMadeSymmetric) {
  const std::vector<std::vector<Neighbor>> neighbors = {
      {To(1), To(2), To(3)}, {To(1), To(7), To(-1), To(3), To(3)}, {}, {}};
  const auto symmetric = SymmetricNeighbors(neighbors, 2);
  EXPECT_EQ(symmetric[0], (std::vector<int>{1, 2}));
  EXPECT_EQ(symmetric[1], (std::vector<int>{3, 0}));
  EXPECT_EQ(symmetric[2], (std::vector<int>{0}));
  EXPECT_EQ(symmetric[3], (std::vector<int>{1}));
}

TEST(QuasiDensePairs, AHubDoesNotOverflowTheSlots) {
  std::vector<std::vector<Neighbor>> neighbors(100);
  for (int v = 1; v < 100; ++v) neighbors[static_cast<size_t>(v)] = {To(0)};
  const auto symmetric = SymmetricNeighbors(neighbors, 8);
  EXPECT_EQ(symmetric[0].size(), 32u);
}

}  // namespace
}  // namespace lsmvs::quasi_dense
