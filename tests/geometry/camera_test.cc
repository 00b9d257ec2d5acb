#include "lsmvs/geometry/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace lsmvs {
namespace {

PinholeCamera SomeCamera() { return {640, 480, 700.0, 720.0, 311.0, 255.5}; }

TEST(PinholeCamera, ProjectAndRayAreInverse) {
  const PinholeCamera camera = SomeCamera();
  for (const Eigen::Vector2d& x :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(123.4, 456.7), Eigen::Vector2d(639.5, 0.5)}) {
    EXPECT_DOUBLE_EQ(camera.Ray(x).z(), 1.0);
    EXPECT_LT((camera.Project(3.7 * camera.Ray(x)) - x).norm(), 1e-10);
  }
  EXPECT_EQ(camera.PixelRay(5, 7), camera.Ray({5.5, 7.5}));
  EXPECT_EQ(camera.Project({0, 0, 2}), Eigen::Vector2d(311.0, 255.5));
}

TEST(PinholeCamera, MatrixProjectsAsProject) {
  const PinholeCamera camera = SomeCamera();
  const Eigen::Vector3d x(0.3, -0.2, 1.7);
  EXPECT_LT(((camera.Matrix() * x).hnormalized() - camera.Project(x)).norm(), 1e-12);
}

TEST(PinholeCamera, ContainsTheHalfOpenImage) {
  const PinholeCamera camera = SomeCamera();
  EXPECT_TRUE(camera.Contains({0, 0}));
  EXPECT_TRUE(camera.Contains({639.999, 479.999}));
  EXPECT_FALSE(camera.Contains({640, 100}));
  EXPECT_FALSE(camera.Contains({100, 480}));
  EXPECT_FALSE(camera.Contains({-1e-9, 100}));
  EXPECT_FALSE(camera.Contains({std::nan(""), 100}));
}

TEST(PinholeCamera, ResizedCoversTheSameFieldOfView) {
  const PinholeCamera camera = SomeCamera();
  for (const Eigen::Vector2i& size :
       {Eigen::Vector2i(320, 240), Eigen::Vector2i(213, 161), Eigen::Vector2i(1280, 960)}) {
    const PinholeCamera resized = camera.Resized(size.x(), size.y());
    EXPECT_EQ(resized.width, size.x());
    EXPECT_EQ(resized.height, size.y());
    // The corners of the image stay the corners.
    EXPECT_LT((resized.Ray({0, 0}) - camera.Ray({0, 0})).norm(), 1e-12);
    EXPECT_LT((resized.Ray({1.0 * size.x(), 1.0 * size.y()}) - camera.Ray({640, 480})).norm(),
              1e-12);
  }
  // Between the centres of the first two pixels lies the centre of the first pixel of half the
  // size.
  const PinholeCamera half = camera.Resized(320, 240);
  EXPECT_LT((half.PixelRay(0, 0) - camera.Ray({1.0, 1.0})).norm(), 1e-12);
}

TEST(PinholeCamera, MeanFocalLengthIsPixelsPerUnitAtDepthOne) {
  EXPECT_DOUBLE_EQ(SomeCamera().MeanFocalLength(), 710.0);
}

}  // namespace
}  // namespace lsmvs
