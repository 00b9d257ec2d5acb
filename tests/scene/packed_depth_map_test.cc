#include "lsmvs/scene/packed_depth_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace lsmvs {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Normals from straight towards the camera to 89.9 degrees away from it.
DepthMap Fan() {
  constexpr int kTilts = 900, kTurns = 36;
  DepthMap map{Raster<float>(kTilts, kTurns), Raster<Eigen::Vector3f>(kTilts, kTurns)};
  for (int row = 0; row < kTurns; ++row) {
    for (int column = 0; column < kTilts; ++column) {
      const double tilt = 0.1 * column * kDegree, turn = 10.3 * row * kDegree;
      map.depth(column, row) = 1.0f + 0.37f * static_cast<float>(column * kTurns + row);
      map.normal(column, row) = Eigen::Vector3d(std::sin(tilt) * std::cos(turn),
                                                std::sin(tilt) * std::sin(turn), -std::cos(tilt))
                                    .cast<float>();
    }
  }
  return map;
}

TEST(PackedDepthMap, KeepsDepthsExactlyAndNormalsClosely) {
  const DepthMap map = Fan();
  const PackedDepthMap packed = Pack(map);
  EXPECT_EQ(packed.NumBytes(), map.depth.size() * 8);
  const DepthMap unpacked = Unpack(packed);
  EXPECT_EQ(unpacked.depth.pixels, map.depth.pixels);
  for (int row = 0; row < map.depth.height; ++row) {
    for (int column = 0; column < map.depth.width; ++column) {
      const Eigen::Vector3d before = map.normal(column, row).cast<double>();
      const Eigen::Vector3d after = unpacked.normal(column, row).cast<double>();
      ASSERT_NEAR(after.norm(), 1, 1e-4);
      ASSERT_LT(after.z(), 0);
      const double degrees = std::atan2(before.cross(after).norm(), before.dot(after)) / kDegree;
      ASSERT_LT(degrees, column < 890 ? 0.12 : 0.6) << column << " " << row;
      ASSERT_LT(degrees, column < 300 ? 0.003 : 0.6) << column << " " << row;
    }
  }
}

TEST(PackedDepthMap, UnknownNormalsStayZero) {
  DepthMap map{Raster<float>(2, 1, 3.0f), Raster<Eigen::Vector3f>(2, 1, {0, 0, 0})};
  map.normal(1, 0) = {-1, 0, 0};
  const DepthMap unpacked = Unpack(Pack(map));
  EXPECT_EQ(unpacked.normal(0, 0), Eigen::Vector3f::Zero());
  EXPECT_NEAR(unpacked.normal(1, 0).x(), -1, 1e-4);
}

TEST(PackedDepthMap, PackingAgainChangesNothing) {
  const DepthMap once = Unpack(Pack(Fan()));
  const DepthMap twice = Unpack(Pack(once));
  EXPECT_EQ(twice.normal.pixels, once.normal.pixels);
}

}  // namespace
}  // namespace lsmvs
