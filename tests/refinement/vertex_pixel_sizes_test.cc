#include "lsmvs/refinement/vertex_pixel_sizes.h"

#include <gtest/gtest.h>

namespace lsmvs {
namespace {

// At z = -distance, looking along z.
PosedCamera ViewFrom(double distance, double focal_length) {
  PosedCamera view;
  view.camera.width = view.camera.height = 100;
  view.camera.fx = view.camera.fy = focal_length;
  view.camera.cx = view.camera.cy = 50;
  view.cam_from_world.translation = {0, 0, distance};
  return view;
}

// Faces the cameras; the second one faces away from them.
TriangleMesh TwoTriangles() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 5}, {1, 0, 5}, {0, 1, 5}};
  mesh.faces = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

TEST(VertexPixelSizes, AreThoseOfTheFinestView) {
  const std::vector<double> sizes = VertexPixelSizes(
      TwoTriangles(), {ViewFrom(10, 100), ViewFrom(20, 400), ViewFrom(30, 100)}, RunContext(1));
  ASSERT_EQ(sizes.size(), 6u);
  for (int v = 0; v < 3; ++v) EXPECT_DOUBLE_EQ(sizes[v], 20.0 / 400);
  for (int v = 3; v < 6; ++v) EXPECT_DOUBLE_EQ(sizes[v], 25.0 / 400);
}

TEST(VertexPixelSizes, FacingViewsAndPicturesComeFirst) {
  TriangleMesh mesh = TwoTriangles();
  PosedCamera aside = ViewFrom(1, 1000);  // the finest, but with nothing in its picture
  aside.cam_from_world.translation.x() = 50;
  PosedCamera behind = ViewFrom(0, 100);  // turned about y, at z = 30: sees the second face's front
  behind.cam_from_world.rotation = Eigen::Vector3d(-1, 1, -1).asDiagonal();
  behind.cam_from_world.translation = {0, 0, 30};
  const std::vector<double> sizes =
      VertexPixelSizes(mesh, {aside, ViewFrom(10, 100), behind}, RunContext(1));
  for (int v = 0; v < 3; ++v) EXPECT_DOUBLE_EQ(sizes[v], 10.0 / 100);
  for (int v = 3; v < 6; ++v) EXPECT_DOUBLE_EQ(sizes[v], 25.0 / 100);
  for (const double size : VertexPixelSizes(mesh, {aside}, RunContext(1))) EXPECT_LE(size, 6e-3);
}

TEST(VertexPixelSizes, WithoutViews) {
  EXPECT_EQ(VertexPixelSizes(TwoTriangles(), {}, RunContext(1)), std::vector<double>(6, 0));
  EXPECT_TRUE(VertexPixelSizes({}, {ViewFrom(1, 1)}, RunContext(1)).empty());
  const std::vector<double> sizes =
      VertexPixelSizes(TwoTriangles(), {ViewFrom(-2, 100)}, RunContext(1));
  EXPECT_EQ(sizes, std::vector<double>(6, 3.0 / 100));
}

}  // namespace
}  // namespace lsmvs
