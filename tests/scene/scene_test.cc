#include "lsmvs/scene/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/truth.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

TEST(View, DepthAndCentreAgreeWithThePose) {
  const SyntheticScene s = MakeScene(ShapeName::kBox, 4, 64, 48);
  for (const View& view : s.scene.views) {
    const Eigen::Vector3d x(0.3, -0.2, 0.5);
    EXPECT_NEAR(view.Depth(x), (view.cam_from_world * x).z(), 1e-12);
    EXPECT_NEAR((view.cam_from_world * view.CenterInWorld()).norm(), 0.0, 1e-12);
  }
}

TEST(EstimateDepthRanges, HoldTheTrueDepths) {
  for (const ShapeName name : {ShapeName::kSphere, ShapeName::kRelief, ShapeName::kTerrain}) {
    const SyntheticScene s = MakeScene(name, 8, 64, 48);
    const auto ranges = EstimateDepthRanges(s.scene);
    for (int v = 0; v < s.scene.num_views(); ++v) {
      const DepthMap map = TrueDepthMap(*s.shape, s.scene.views[v], RunContext());
      int num_inside = 0, num_known = 0;
      for (const float depth : map.depth.pixels) {
        if (depth == 0) continue;
        ++num_known;
        num_inside += depth >= ranges[v].min && depth <= ranges[v].max;
      }
      EXPECT_GT(num_inside, 0.99 * num_known);
      EXPECT_GT(ranges[v].min, 0.0);
      EXPECT_LT(ranges[v].max, 6 * ranges[v].min);
    }
  }
}

// A view that no track has takes the depths of what lies in its image, not of all that lies before
// it.
TEST(EstimateDepthRanges, ViewWithoutPointsTakesThoseInItsImage) {
  SyntheticScene s = MakeScene(ShapeName::kSphere, 6, 64, 48);
  const auto own = EstimateDepthRanges(s.scene);
  for (SparsePoint& point : s.scene.points) std::erase(point.view_idxs, 2);
  // Ground far beside what view 2 looks at, and farther away.
  const View& view = s.scene.views[2];
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const size_t num_points = s.scene.points.size();
  for (size_t i = 0; i < num_points; ++i) {
    SparsePoint point;
    point.x_in_world = world_from_cam * Eigen::Vector3d(300 * own[2].max, 0, 100 * own[2].max);
    s.scene.points.push_back(point);
  }
  const auto in_image = PointsInImage(s.scene, 2);
  EXPECT_GT(in_image.size(), kMinPointsOfView);
  for (const uint32_t p : in_image) EXPECT_LT(p, num_points);
  const auto ranges = EstimateDepthRanges(s.scene);
  EXPECT_LT(ranges[2].max, 2 * own[2].max);
  EXPECT_LE(ranges[2].min, own[2].min * 1.01);
}

TEST(MeanTrackLength, CountsPointsThatTwoOrMoreViewsSee) {
  Scene scene;
  EXPECT_EQ(MeanTrackLength(scene), 4);
  for (const std::vector<int>& views : {std::vector<int>{0}, {0, 1}, {0, 1, 2, 3, 4}}) {
    scene.points.push_back({});
    scene.points.back().view_idxs = views;
  }
  EXPECT_EQ(MeanTrackLength(scene), 3.5);
}

TEST(EstimateDepthRanges, OutliersDoNotWidenThem) {
  SyntheticScene s = MakeScene(ShapeName::kSphere, 6, 64, 48);
  const auto clean = EstimateDepthRanges(s.scene);
  for (int i = 0; i < 10; ++i) s.scene.points[i].x_in_world *= 1000.0;
  const auto dirty = EstimateDepthRanges(s.scene);
  for (size_t v = 0; v < clean.size(); ++v) {
    EXPECT_NEAR(dirty[v].max / clean[v].max, 1.0, 0.1);
    EXPECT_NEAR(dirty[v].min / clean[v].min, 1.0, 0.1);
  }
}

TEST(EstimateDepthRanges, ViewWithoutPointsBorrowsAndNoPointsGiveZero) {
  SyntheticScene s = MakeScene(ShapeName::kSphere, 6, 64, 48);
  for (SparsePoint& point : s.scene.points) std::erase(point.view_idxs, 2);
  const auto ranges = EstimateDepthRanges(s.scene);
  EXPECT_GT(ranges[2].min, 0.5 * ranges[1].min);
  EXPECT_LT(ranges[2].max, 2.0 * ranges[1].max);
  s.scene.points.clear();
  EXPECT_EQ(EstimateDepthRanges(s.scene)[0].max, 0.0);
  EXPECT_TRUE(EstimateDepthRanges(Scene()).empty());
}

TEST(GroundSamplingDistance, IsOnePixelOnTheSurfaceAndScales) {
  SyntheticScene s = MakeScene(ShapeName::kStep, 6, 64, 48);
  const double gsd = GroundSamplingDistance(s.scene);
  const View& view = s.scene.views[0];
  EXPECT_NEAR(gsd / (view.Depth({0, 0, 0}) / view.camera.fx), 1.0, 0.2);
  for (SparsePoint& point : s.scene.points) point.x_in_world *= 7.0;
  for (View& v : s.scene.views) v.cam_from_world.translation *= 7.0;
  EXPECT_NEAR(GroundSamplingDistance(s.scene) / gsd, 7.0, 1e-9);
  EXPECT_EQ(GroundSamplingDistance(Scene()), 0.0);
}

TEST(MakeImageStore, FindsPhotosAndThoseMasksThatExist) {
  SyntheticScene s = MakeScene(ShapeName::kSphere, 3, 32, 24);
  const TemporaryFolder folder;
  s.scene.views[1].name = "sub/photo 1.png";
  WritePhotos(*s.shape, s.photo, (folder.path() / "images").string(), &s.scene, RunContext());
  s.scene.mask_folder = (folder.path() / "masks").string();
  WritePng(folder.path() / "masks/sub/photo 1.png.png", ColorImage(32, 24, Color(0, 0, 0)));
  const auto store = MakeImageStore(s.scene, ImageStoreOptions());
  ASSERT_EQ(store->num_views(), 3u);
  EXPECT_EQ(store->Colors(1, 0)->width, 32);
  EXPECT_EQ(store->Mask(0, 0), nullptr);
  ASSERT_NE(store->Mask(1, 0), nullptr);
  EXPECT_EQ((*store->Mask(1, 0))(5, 5), 0);
}

}  // namespace
}  // namespace lsmvs
