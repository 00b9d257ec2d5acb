#include "lsmvs/exporting/tiles/same_side.h"

#include <gtest/gtest.h>

namespace lsmvs {
namespace {

// A wall between z = 0 (looks down) and z = 0.1 (looks up).
TriangleMesh ThinWall() {
  TriangleMesh mesh;
  for (const double z : {0.0, 0.1}) {
    for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      mesh.vertices.emplace_back(x, y, z);
    }
  }
  mesh.faces = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  return mesh;
}

TEST(SameSide, BackOfAThinWallDoesNotShowThrough) {
  const TriangleMesh mesh = ThinWall();
  const MeshTracer tracer(mesh, RunContext(1));
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  // Nearer to the lower side, or even below it, but of the upper one.
  for (const double z : {0.02, -0.05}) {
    const auto found = ClosestOnSameSide(tracer, mesh, {0.4, 0.3, z}, 2 * up, 1);
    ASSERT_TRUE(found);
    EXPECT_GE(found->face, 2);
    EXPECT_LT((found->x_in_world - Eigen::Vector3d(0.4, 0.3, 0.1)).norm(), 1e-6);
  }
  EXPECT_LT(ClosestOnSameSide(tracer, mesh, {0.4, 0.3, 0.08}, -up, 1)->face, 2);
}

TEST(SameSide, OtherwiseTheNearest) {
  const TriangleMesh mesh = ThinWall();
  const MeshTracer tracer(mesh, RunContext(1));
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  EXPECT_GE(ClosestOnSameSide(tracer, mesh, {0.4, 0.3, 0.3}, up, 1)->face, 2);
  // Too far for `reach`, beside the wall, or without a normal: whatever is nearest.
  EXPECT_LT(ClosestOnSameSide(tracer, mesh, {0.4, 0.3, 0.02}, up, 0.01)->face, 2);
  EXPECT_LT(ClosestOnSameSide(tracer, mesh, {3, 0.3, 0.02}, up, 1)->face, 2);
  EXPECT_LT(ClosestOnSameSide(tracer, mesh, {0.4, 0.3, 0.02}, Eigen::Vector3d::Zero(), 1)->face, 2);
}

}  // namespace
}  // namespace lsmvs
