#include "lsmvs/image/rasterizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/mesh_shape.h"
#include "lsmvs/synthetic/named_shapes.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/truth.h"

namespace lsmvs {
namespace {

SurfaceMaps Rasterize(const PinholeCamera& camera, const Rigid3& cam_from_world,
                      const TriangleMesh& mesh, bool cull = false) {
  SurfaceMaps maps;
  RasterizeMesh(camera, cam_from_world, mesh.vertices, mesh.faces, {cull}, &maps);
  return maps;
}

TEST(Rasterizer, AgreesWithRayCasting) {
  for (const ShapeName name : {ShapeName::kTorus, ShapeName::kRelief, ShapeName::kTerrain}) {
    const SyntheticScene s = MakeScene(name, 4, 120, 90);
    const TriangleMesh mesh = s.shape->Mesh(0.15);
    const MeshShape oracle(mesh);
    for (const View& view : s.scene.views) {
      const SurfaceMaps maps = Rasterize(view.camera, view.cam_from_world, mesh);
      const DepthMap truth = TrueDepthMap(oracle, view, RunContext());
      ASSERT_EQ(maps.depth.width, 120);
      ASSERT_EQ(maps.face.height, 90);
      int num_different = 0;
      for (size_t i = 0; i < truth.depth.size(); ++i) {
        EXPECT_EQ(maps.depth.pixels[i] > 0, maps.face.pixels[i] >= 0);
        const float a = maps.depth.pixels[i], b = truth.depth.pixels[i];
        num_different += std::abs(a - b) > 1e-5f * b;
      }
      // A ray through an edge of the silhouette may be rounded to either side.
      EXPECT_LE(num_different, 3);
    }
  }
}

TEST(Rasterizer, NeighboursLeaveNoGapAndDoNotOverlap) {
  // A square of the camera's whole field, cut into triangles through pixel centres: each face alone
  // must give a partition.
  const PinholeCamera camera{16, 16, 16, 16, 8, 8};
  TriangleMesh mesh;
  mesh.vertices = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}, {0.03125, 0.03125, 1}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  Raster<int> count(16, 16, 0);
  for (const Eigen::Vector3i& face : mesh.faces) {
    TriangleMesh one = mesh;
    one.faces = {face};
    const SurfaceMaps maps = Rasterize(camera, Rigid3(), one);
    for (size_t i = 0; i < count.size(); ++i) count.pixels[i] += maps.face.pixels[i] == 0;
  }
  for (const int n : count.pixels) EXPECT_EQ(n, 1);
}

TEST(Rasterizer, NearestFaceWinsAndTiesGoToTheLowestIndex) {
  const PinholeCamera camera{8, 8, 8, 8, 4, 4};
  TriangleMesh mesh;
  for (const double z : {2.0, 1.0, 1.0}) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{-9, -9, z}, {9, -9, z}, {0, 18, z}});
    mesh.faces.emplace_back(first, first + 1, first + 2);
  }
  const SurfaceMaps maps = Rasterize(camera, Rigid3(), mesh);
  for (const int32_t face : maps.face.pixels) EXPECT_EQ(face, 1);
  for (const float depth : maps.depth.pixels) EXPECT_EQ(depth, 1.0f);
}

TEST(Rasterizer, DepthOfASlantedPlaneIsPerspectiveCorrect) {
  const PinholeCamera camera{40, 30, 35, 35, 20, 15};
  // The plane z = 3 + 0.7 x - 0.4 y.
  const auto on_plane = [](double x, double y) {
    return Eigen::Vector3d(x, y, 3 + 0.7 * x - 0.4 * y);
  };
  TriangleMesh mesh;
  mesh.vertices = {on_plane(-3, -3), on_plane(9, -3), on_plane(-3, 9)};
  mesh.faces = {{0, 1, 2}};
  const SurfaceMaps maps = Rasterize(camera, Rigid3(), mesh);
  int num_seen = 0;
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      if (maps.face(column, row) < 0) continue;
      ++num_seen;
      const Eigen::Vector3d ray = camera.PixelRay(column, row);
      EXPECT_NEAR(maps.depth(column, row), 3 / (1 - 0.7 * ray.x() + 0.4 * ray.y()), 1e-5);
    }
  }
  EXPECT_GT(num_seen, 500);
}

TEST(Rasterizer, CullsFacesSeenFromBehind) {
  const SyntheticScene s = MakeScene(ShapeName::kSphere, 3, 60, 45);
  TriangleMesh mesh = s.shape->Mesh(0.2);
  const View& view = s.scene.views[0];
  const SurfaceMaps all = Rasterize(view.camera, view.cam_from_world, mesh);
  const SurfaceMaps front = Rasterize(view.camera, view.cam_from_world, mesh, true);
  EXPECT_EQ(all.face.pixels, front.face.pixels);
  for (Eigen::Vector3i& f : mesh.faces) std::swap(f[0], f[1]);
  const SurfaceMaps inner = Rasterize(view.camera, view.cam_from_world, mesh, true);
  for (size_t i = 0; i < inner.depth.size(); ++i) {
    if (all.depth.pixels[i] > 0 && inner.depth.pixels[i] > 0) {
      EXPECT_GE(inner.depth.pixels[i], all.depth.pixels[i]);
    }
  }
  EXPECT_GT(inner.depth(30, 22), all.depth(30, 22) + 1.5f);
}

TEST(Rasterizer, ClipsWhatReachesBehindTheCamera) {
  // A floor one unit below the camera that goes on behind it.
  const PinholeCamera camera{20, 20, 10, 10, 10, 10};
  TriangleMesh mesh;
  mesh.vertices = {{-100, 1, -100}, {100, 1, -100}, {0, 1, 300}};
  mesh.faces = {{0, 1, 2}};
  const SurfaceMaps maps = Rasterize(camera, Rigid3(), mesh);
  for (int row = 0; row < 20; ++row) {
    for (int column = 5; column < 15; ++column) {
      const double down = camera.PixelRay(column, row).y();
      const double expected = down > 0 ? 1 / down : 0.0;
      EXPECT_NEAR(maps.depth(column, row), expected, 1e-4 * expected) << column << " " << row;
    }
  }
}

TEST(Rasterizer, OddInputDrawsNothing) {
  const PinholeCamera camera{8, 8, 8, 8, 4, 4};
  TriangleMesh mesh;
  EXPECT_EQ(Rasterize(camera, Rigid3(), mesh).face(3, 3), -1);
  mesh.vertices = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {0, 0, 1}, {1, 1, 1}, {2, 2, 1}};
  mesh.faces = {{0, 1, 2}, {3, 4, 5}, {3, 3, 4}};  // behind; a line; a line
  for (const int32_t face : Rasterize(camera, Rigid3(), mesh).face.pixels) EXPECT_EQ(face, -1);
}

}  // namespace
}  // namespace lsmvs
