#include "lsmvs/image/face_blocks.h"

#include <gtest/gtest.h>

#include <random>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/named_shapes.h"
#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

TEST(MayShow, IsNeverFalseForABoxOfWhichAPointIsInThePicture) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-4, 4), length(0, 2), share(0, 1);
  const PinholeCamera camera = MakeCamera(60, 40, 0.7);
  int num_shown = 0, num_culled = 0;
  for (int k = 0; k < 4000; ++k) {
    const auto point = [&](auto& d) { return Eigen::Vector3d(d(random), d(random), d(random)); };
    const Rigid3 pose = LookAt(point(place), point(place));
    const Eigen::Vector3d low = point(place), high = low + point(length);
    bool shown = false;
    for (int n = 0; n < 200 && !shown; ++n) {
      const Eigen::Vector3d x = pose * (low + point(share).cwiseProduct(high - low));
      shown = x.z() > 0 && camera.Contains(camera.Project(x));
    }
    const bool may_show = MayShow(camera, pose, {low, high});
    EXPECT_TRUE(may_show || !shown) << k;
    num_shown += shown;
    num_culled += !may_show;
  }
  EXPECT_GT(num_shown, 200);
  EXPECT_GT(num_culled, 2000);
}

TEST(FaceBlocks, MapsAreTheSame) {
  for (const ShapeName name : {ShapeName::kTown, ShapeName::kRelief, ShapeName::kTorus}) {
    const SyntheticScene s = MakeScene(name, 4, 120, 90);
    const TriangleMesh mesh = s.shape->Mesh(0.05);
    const FaceBlocks blocks(mesh.vertices, mesh.faces, RunContext(2));
    for (View view : s.scene.views) {
      // As it is, and from within the scene, where much is behind the camera.
      for (int k = 0; k < 2; ++k) {
        SurfaceMaps all, seen;
        RasterizeMesh(view.camera, view.cam_from_world, mesh.vertices, mesh.faces, {}, &all);
        RasterizeMesh(view.camera, view.cam_from_world, mesh.vertices, mesh.faces,
                      {.blocks = &blocks}, &seen);
        EXPECT_EQ(all.depth.pixels, seen.depth.pixels);
        EXPECT_EQ(all.face.pixels, seen.face.pixels);
        const Eigen::Vector3d target = s.shape->Bounds().center();
        view.cam_from_world =
            LookAt(0.7 * target + 0.3 * view.CenterInWorld(), target + Eigen::Vector3d(1, 2, 0.5));
      }
    }
  }
}

TEST(FaceBlocks, LeavesOutWhatTheCameraDoesNotShow) {
  SyntheticSceneOptions options;
  options.shape = ShapeName::kTown;
  options.num_views = 36;
  options.width = 120;
  options.height = 90;
  const SyntheticScene s = MakeScene(options, RunContext(2));
  const TriangleMesh mesh = s.shape->Mesh(1);
  const FaceBlocks blocks(mesh.vertices, mesh.faces, RunContext(1));
  const size_t num_blocks =
      (mesh.faces.size() + FaceBlocks::kFacesPerBlock - 1) / FaceBlocks::kFacesPerBlock;
  size_t num_seen = 0;
  for (const View& view : s.scene.views) {
    num_seen += blocks.SeenBy(view.camera, view.cam_from_world).size();
  }
  EXPECT_GT(num_seen, 0u);
  EXPECT_LT(num_seen, s.scene.views.size() * num_blocks * 3 / 4);
}

}  // namespace
}  // namespace lsmvs
