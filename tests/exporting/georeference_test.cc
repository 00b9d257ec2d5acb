#include "lsmvs/exporting/georeference.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace lsmvs {
namespace {

using Eigen::Vector3d;

TEST(Georeference, KnownPlaces) {
  EXPECT_LT((EcefFromGeodetic({0, 0, 0}) - Vector3d(6378137, 0, 0)).norm(), 1e-6);
  EXPECT_LT((EcefFromGeodetic({0, 90, 100}) - Vector3d(0, 6378237, 0)).norm(), 1e-6);
  EXPECT_LT((EcefFromGeodetic({90, 0, 0}) - Vector3d(0, 0, 6356752.314245)).norm(), 1e-6);
  // 45 N: radius of curvature a / sqrt(1 - e2 / 2).
  EXPECT_LT((EcefFromGeodetic({45, 0, 0}) - Vector3d(4517590.878845, 0, 4487348.408866)).norm(),
            1e-5);
}

TEST(Georeference, EastNorthUp) {
  const Eigen::Matrix4d t = EcefFromEnu({48.2, 16.37, 171});
  EXPECT_LT(
      (t.topLeftCorner<3, 3>() * t.topLeftCorner<3, 3>().transpose() - Eigen::Matrix3d::Identity())
          .norm(),
      1e-12);
  EXPECT_NEAR((t.topLeftCorner<3, 3>().determinant()), 1, 1e-12);
  const Vector3d origin = EcefFromGeodetic({48.2, 16.37, 171});
  const double step = 1e-5;  // degrees: about a metre
  const Vector3d north = EcefFromGeodetic({48.2 + step, 16.37, 171}) - origin;
  const Vector3d east = EcefFromGeodetic({48.2, 16.37 + step, 171}) - origin;
  const Vector3d up = EcefFromGeodetic({48.2, 16.37, 172}) - origin;
  EXPECT_GT((t.col(0).head<3>().dot(east.normalized())), 1 - 1e-9);
  EXPECT_GT((t.col(1).head<3>().dot(north.normalized())), 1 - 1e-9);
  EXPECT_GT((t.col(2).head<3>().dot(up.normalized())), 1 - 1e-9);
  EXPECT_EQ((t.col(3).head<3>()), origin);
}

}  // namespace
}  // namespace lsmvs
