#include "lsmvs/evaluation/mesh_renderer.h"

#include <gtest/gtest.h>

#include "lsmvs/test_evaluation/test_meshes.h"

namespace lsmvs {
namespace {

ColorImage Render(const TriangleMesh& mesh, const PosedCamera& viewpoint,
                  const RenderOptions& options = {}, int threads = 2) {
  const RunContext context(threads);
  return RenderMesh(mesh, MeshTracer(mesh, context), viewpoint, options, context);
}

PosedCamera Turntable(const TriangleMesh& mesh, double azimuth_deg, double elevation_deg, int width,
                      int height) {
  TurntableOptions options;
  options.azimuth_deg = azimuth_deg;
  options.elevation_deg = elevation_deg;
  options.width = width;
  options.height = height;
  return TurntableViewpoint(mesh.vertices, options);
}

TEST(MeshRenderer, ColoursAreThoseOfTheVertices) {
  TriangleMesh mesh = test::PlaneMesh(10, 10, 0);
  mesh.vertex_colors.assign(mesh.vertices.size(), Color(200, 100, 50));
  const View view = test::DownwardView({5, 5, 20}, 40, 40, 80);
  RenderOptions options;
  options.style = RenderStyle::kColor;
  const ColorImage image = Render(mesh, {view.camera, view.cam_from_world}, options);
  EXPECT_EQ(image(20, 20), Color(200, 100, 50));
  EXPECT_EQ(image.width, 40);
}

TEST(MeshRenderer, PixelsLieWhereTheCameraProjects) {
  // A square that covers columns and rows [10, 20) of the image exactly.
  const View view = test::DownwardView({0, 0, 10}, 40, 40, 100);
  const TriangleMesh mesh = test::Scaled(test::PlaneMesh(1, 1, 0), 1, {-1, 0, 0});
  RenderOptions options;
  options.style = RenderStyle::kNormals;
  const ColorImage image = Render(mesh, {view.camera, view.cam_from_world}, options);
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 40; ++column) {
      const bool inside = column >= 10 && column < 20 && row >= 10 && row < 20;
      ASSERT_EQ(image(column, row)[2] == 255, inside) << column << " " << row;
    }
  }
}

TEST(MeshRenderer, TurntableShowsAllOfTheMesh) {
  const TriangleMesh mesh = test::Scaled(test::SphereMesh(3, 24), 1, {100, -50, 7});
  for (const double azimuth : {0.0, 77.0, 200.0}) {
    const PosedCamera viewpoint = Turntable(mesh, azimuth, 25, 160, 120);
    int inside = 0;
    for (const Eigen::Vector3d& x : mesh.vertices) {
      const Eigen::Vector3d x_in_cam = viewpoint.cam_from_world * x;
      ASSERT_GT(x_in_cam.z(), 0);
      ASSERT_TRUE(viewpoint.camera.Contains(viewpoint.camera.Project(x_in_cam)));
      inside += std::abs(viewpoint.camera.Project(x_in_cam).y() - 60) > 50;
    }
    EXPECT_GT(inside, 0);  // and fills the image
    // Up is up.
    const Eigen::Vector3d top = viewpoint.cam_from_world * Eigen::Vector3d(100, -50, 10);
    EXPECT_LT(viewpoint.camera.Project(top).y(), 60);
  }
}

TEST(MeshRenderer, TurntableFacesTheFront) {
  TurntableOptions options;
  options.front = {1, 2, 5};
  options.elevation_deg = 0;
  const PosedCamera viewpoint = TurntableViewpoint(test::SphereMesh(1, 12).vertices, options);
  const Eigen::Vector3d center = viewpoint.cam_from_world.OriginInSource();
  EXPECT_NEAR(center.normalized().dot(Eigen::Vector3d(1, 2, 0).normalized()), 1, 1e-6);
  EXPECT_NEAR(viewpoint.cam_from_world.rotation.determinant(), 1, 1e-12);
}

TEST(MeshRenderer, TurntableIgnoresOutliersWhenAsked) {
  TriangleMesh mesh = test::SphereMesh(1, 24);
  mesh.vertices.emplace_back(1000, 0, 0);
  TurntableOptions options;
  options.fit_share = 0.99;
  const PosedCamera viewpoint = TurntableViewpoint(mesh.vertices, options);
  EXPECT_LT(viewpoint.cam_from_world.OriginInSource().norm(), 5);
}

TEST(MeshRenderer, OcclusionDarkensCorners) {
  // Two walls and a floor: near the corner the light is dimmer.
  TriangleMesh mesh = test::PlaneMesh(10, 10, 0);
  const int first = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3d& x : test::PlaneMesh(10, 10, 0).vertices)
    mesh.vertices.emplace_back(0, x.y(), x.x());
  for (const Eigen::Vector3i& f : test::PlaneMesh(10, 10, 0).faces)
    mesh.faces.push_back(f + Eigen::Vector3i::Constant(first));
  const View view = test::DownwardView({5, 5, 30}, 60, 60, 180);
  RenderOptions options;
  options.num_occlusion_rays = 32;
  options.occlusion_radius = 0.3;
  const ColorImage image = Render(mesh, {view.camera, view.cam_from_world}, options);
  EXPECT_LT(image(2, 30)[0] + 15, image(50, 30)[0]);
}

TEST(MeshRenderer, ThreadsChangeNothing) {
  const TriangleMesh mesh = test::SphereMesh(1, 20);
  const PosedCamera viewpoint = Turntable(mesh, 10, 10, 50, 40);
  for (const RenderStyle style : {RenderStyle::kShaded, RenderStyle::kLit, RenderStyle::kDepth}) {
    RenderOptions options;
    options.style = style;
    options.smooth = true;
    EXPECT_EQ(Render(mesh, viewpoint, options, 1).pixels,
              Render(mesh, viewpoint, options, 2).pixels);
  }
}

TEST(MeshRenderer, AnEmptyMeshIsBackground) {
  const PosedCamera viewpoint = Turntable({}, 0, 0, 8, 8);
  EXPECT_EQ(Render({}, viewpoint)(0, 0)[0], Render({}, viewpoint)(7, 0)[0]);
}

TEST(RenderOptions, BoundsAreNamed) {
  std::string error;
  EXPECT_TRUE(RenderOptions().Check(&error));
  RenderOptions options;
  options.antialiasing = 0;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_NE(error.find("antialiasing"), std::string::npos);
}

}  // namespace
}  // namespace lsmvs
