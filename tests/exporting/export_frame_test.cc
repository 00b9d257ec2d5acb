#include "lsmvs/exporting/export_frame.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "lsmvs/exporting_test/textured_blob.h"

namespace lsmvs {
namespace {

using Eigen::Vector3d;

TEST(ExportFrame, DefaultTurnsColmapsCameraUpright) {
  EXPECT_EQ(YUpFromWorld({}), Eigen::Matrix3d(Vector3d(1, -1, -1).asDiagonal()));
  EXPECT_EQ(ZUpFromWorld({}) * Vector3d(0, -1, 0), Vector3d::UnitZ());
}

TEST(ExportFrame, UpAndViewerGoWhereTheFormatsWantThem) {
  const ExportDirections directions = {Vector3d(1, 2, 3), Vector3d(3, -1, 0.5)};
  const Eigen::Matrix3d y_up = YUpFromWorld(directions), z_up = ZUpFromWorld(directions);
  for (const Eigen::Matrix3d& r : {y_up, z_up}) {
    EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(r.determinant(), 1, 1e-12);
  }
  EXPECT_LT((y_up * directions.up.normalized() - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((z_up * directions.up.normalized() - Vector3d::UnitZ()).norm(), 1e-12);
  const Vector3d viewer = y_up * directions.to_viewer;
  EXPECT_GT(viewer.z(), 0);
  EXPECT_NEAR(viewer.x(), 0, 1e-12);
  EXPECT_LT((z_up * directions.to_viewer).y(), 0);
}

TEST(ExportFrame, ViewerAboveIsNoFault) {
  const Eigen::Matrix3d r = YUpFromWorld({Vector3d::UnitX(), Vector3d::UnitX()});
  EXPECT_NEAR(r.determinant(), 1, 1e-12);
}

TEST(ExportFrame, OffsetOnlyWhereSinglePrecisionNeedsIt) {
  TriangleMesh mesh = BlobMesh(0.5);
  EXPECT_TRUE(ExportOffset(mesh).isZero(0.0));
  const Vector3d far(431000.25, 5411000.5, 200);
  for (Vector3d& x : mesh.vertices) x += far;
  const Vector3d offset = ExportOffset(mesh);
  EXPECT_LT((offset - far).norm(), 2);
  EXPECT_EQ(offset, Vector3d(offset.array().round()));
  EXPECT_TRUE(ExportOffset(TriangleMesh()).isZero(0.0));
}

}  // namespace
}  // namespace lsmvs
