#include "lsmvs/stereo/sampling/plane_map.h"

#include <gtest/gtest.h>

#include "lsmvs/stereo/sampling/packed_image.h"

namespace lsmvs {
namespace {

const PinholeCamera kCamera{64, 48, 70.0, 72.0, 31.0, 25.0};
// The plane normal . x = offset, in the camera frame.
const Eigen::Vector3d kNormal = Eigen::Vector3d(0.2, -0.3, -0.9).normalized();
constexpr double kOffset = -4.0;

double DepthOnPlane(const PinholeCamera& camera, const Eigen::Vector2d& x_px) {
  return kOffset / kNormal.dot(camera.Ray(x_px));
}

TEST(Plane, MovesExactlyAcrossTheImage) {
  const Eigen::Vector2d from(10.5, 20.5), to(50.5, 3.5);
  const Plane plane = PlaneFromDepth(kCamera, from, DepthOnPlane(kCamera, from), kNormal);
  const Plane moved = plane.Moved(40, -17);
  EXPECT_NEAR(1 / moved.q, DepthOnPlane(kCamera, to), 1e-4);
  EXPECT_LT((PlaneNormal(kCamera, to, moved).cast<double>() - kNormal).norm(), 1e-5);
}

TEST(Plane, HasNoSlopeWithoutANormal) {
  const Plane plane = PlaneFromDepth(kCamera, {5.5, 5.5}, 2.0, Eigen::Vector3d::Zero());
  EXPECT_FLOAT_EQ(plane.q, 0.5f);
  EXPECT_EQ(plane.qx, 0);
  EXPECT_EQ(plane.qy, 0);
  EXPECT_EQ(PlaneFromDepth(kCamera, {5.5, 5.5}, 0.0, kNormal).q, 0);
}

DepthMap PlaneDepthMap(const PinholeCamera& camera) {
  DepthMap map{Raster<float>(camera.width, camera.height),
               Raster<Eigen::Vector3f>(camera.width, camera.height, kNormal.cast<float>())};
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      map.depth(column, row) = static_cast<float>(DepthOnPlane(camera, {column + 0.5, row + 0.5}));
    }
  }
  return map;
}

void ExpectSame(const DepthMap& a, const DepthMap& b) {
  ASSERT_EQ(a.depth.size(), b.depth.size());
  for (size_t i = 0; i < a.depth.size(); ++i) {
    EXPECT_NEAR(a.depth.pixels[i], b.depth.pixels[i], 2e-5f * b.depth.pixels[i]);
    EXPECT_LT((a.normal.pixels[i] - b.normal.pixels[i]).norm(), 1e-3f);
  }
}

TEST(PlaneMap, RoundTripsDepthMaps) {
  DepthMap map = PlaneDepthMap(kCamera);
  map.depth(3, 4) = 0;
  map.normal(3, 4).setZero();
  const DepthMap back = ToDepthMap(kCamera, ToPlaneMap(kCamera, map));
  ExpectSame(back, map);
  EXPECT_EQ(back.depth(3, 4), 0);
}

TEST(PlaneMap, ResizesAPlaneExactly) {
  const PinholeCamera half = kCamera.Resized(32, 24);
  const PlaneMap planes = ToPlaneMap(half, PlaneDepthMap(half));
  ExpectSame(ToDepthMap(kCamera, ResizePlaneMap(planes, 64, 48)), PlaneDepthMap(kCamera));
}

TEST(PackedImage, HoldsFourPixelsACellAndRepeatsBorders) {
  GrayImage image(3, 2);
  const float grays[] = {0.4f, 10.6f, 20.0f, 255.0f, 40.0f, 300.0f};
  std::copy(grays, grays + 6, image.pixels.begin());
  const PackedImage cells(image);
  const auto cell = [&](int column, int row) {
    return cells.Origin()[row * cells.stride + column];
  };
  const auto pack = [](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    return a | b << 8 | c << 16 | d << 24;
  };
  EXPECT_EQ(cell(0, 0), pack(0, 11, 255, 40));
  EXPECT_EQ(cell(1, 0), pack(11, 20, 40, 255));
  EXPECT_EQ(cell(2, 1), pack(255, 255, 255, 255));
  EXPECT_EQ(cell(-1, 0), pack(0, 0, 255, 255));
  EXPECT_EQ(cell(-8, -8), pack(0, 0, 0, 0));
  EXPECT_EQ(cell(10, 9), pack(255, 255, 255, 255));
}

}  // namespace
}  // namespace lsmvs
