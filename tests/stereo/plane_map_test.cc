#include "lsmvs/stereo/plane_map.h"

#include <gtest/gtest.h>

#include "lsmvs/stereo/packed_image.h"

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

TEST(PackedImage, HoldsBilinearCoefficientsAndRepeatsBorders) {
  GrayImage image(3, 2);
  const float grays[] = {0.25f, 10.25f, 20.25f, 255.0f, 40.25f, 0.0f};
  std::copy(grays, grays + 6, image.pixels.begin());
  const PackedImage packed(image);
  const auto number = [&](int column, int row, int which) {
    const uint64_t element = packed.Origin()[row * packed.stride + column];
    return static_cast<float>(static_cast<int16_t>(element >> (16 * which))) / PackedImage::kScale;
  };
  EXPECT_EQ(number(0, 0, 0), 0.25f);
  EXPECT_EQ(number(0, 0, 1), 10.0f);
  EXPECT_EQ(number(0, 0, 2), 254.75f);
  EXPECT_EQ(number(0, 0, 3), 40.25f - 255.0f - 10.0f);
  EXPECT_EQ(number(2, 1, 0), 0.0f);
  EXPECT_EQ(number(2, 1, 1), 0.0f);
  EXPECT_EQ(number(-8, -8, 0), 0.25f);
  EXPECT_EQ(number(-8, -8, 3), 0.0f);
  EXPECT_EQ(number(10, 9, 0), 0.0f);
}

TEST(PackedImage, HoldsTheLargestDifferences) {
  GrayImage image(2, 2);
  image.pixels = {0, 255, 255, 0};
  const uint64_t element = PackedImage(image).Origin()[0];
  EXPECT_EQ(static_cast<int16_t>(element >> 48), -510 * static_cast<int>(PackedImage::kScale));
}

}  // namespace
}  // namespace lsmvs
