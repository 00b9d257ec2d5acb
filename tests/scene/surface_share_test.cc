#include "lsmvs/scene/surface_share.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "lsmvs/synthetic/cameras.h"

namespace lsmvs {
namespace {

constexpr int kWidth = 640, kHeight = 480;

// Views that look straight down on the plane z = 0 from `distance`, `step` apart, with points of
// the plane everywhere, in the tracks of all views whose image they lie in.
Scene PlaneScene(int num_views, double step, double distance) {
  Scene scene;
  for (int v = 0; v < num_views; ++v) {
    const Eigen::Quaterniond down(0, 1, 0, 0);  // half a turn about x
    const Eigen::Vector3d center(step * v, 0, distance);
    scene.views.push_back(MakeView(v, MakeCamera(kWidth, kHeight), Rigid3(down, -(down * center))));
  }
  for (double x = -6; x < 6 + step * num_views; x += 0.05) {
    for (double y = -3; y < 3; y += 0.05) {
      SparsePoint point;
      point.x_in_world = {x, y, 0};
      for (int v = 0; v < num_views; ++v) {
        const View& view = scene.views[static_cast<size_t>(v)];
        if (view.camera.Contains(view.camera.Project(view.cam_from_world * point.x_in_world))) {
          point.view_idxs.push_back(v);
        }
      }
      if (!point.view_idxs.empty()) scene.points.push_back(point);
    }
  }
  return scene;
}

// One photo alone shows every pixel once; its value carries the calibration of the others.
double ShareOfOneView() { return EstimateSurfaceShare(PlaneScene(1, 1.0, 2.0)).once; }

TEST(EstimateSurfaceShare, OneViewShowsEachPixelOnce) {
  const SurfaceShare share = EstimateSurfaceShare(PlaneScene(1, 1.0, 2.0));
  EXPECT_NEAR(share.covered, 1.0, 0.05);
  EXPECT_LE(share.once, share.covered);
  EXPECT_GT(share.once, 0.5);
}

TEST(EstimateSurfaceShare, FallsWithTheNumberOfPhotosThatShowTheSame) {
  for (const int count : {2, 5, 10}) {
    const SurfaceShare share = EstimateSurfaceShare(PlaneScene(count, 1e-4, 2.0));
    EXPECT_NEAR(share.covered, 1.0, 0.05);
    EXPECT_NEAR(share.once, ShareOfOneView() / count, 0.05 / count);
  }
}

// Strips that overlap by half: so much surface as one photo shows, and half a photo for each other.
TEST(EstimateSurfaceShare, CountsWhatOverlapsOnce) {
  const View view = PlaneScene(1, 1, 2).views[0];
  const double width = 2.0 * kWidth / view.camera.fx;  // of an image on the plane
  constexpr int kNumViews = 8;
  const SurfaceShare share = EstimateSurfaceShare(PlaneScene(kNumViews, width / 2, 2.0));
  const double expected = (1 + 0.5 * (kNumViews - 1)) / kNumViews;
  EXPECT_NEAR(share.once / ShareOfOneView(), expected, 0.05);
}

TEST(EstimateSurfaceShare, TheFinestPhotoCounts) {
  Scene scene = PlaneScene(1, 1.0, 1.0);
  View far = PlaneScene(1, 1.0, 2.0).views[0];
  scene.views.push_back(far);
  for (SparsePoint& point : scene.points) point.view_idxs.push_back(1);
  // All that the near one shows, whose pixels are as many as the far one's: half of all.
  EXPECT_NEAR(EstimateSurfaceShare(scene).once / ShareOfOneView(), 0.5, 0.1);
}

TEST(EstimateSurfaceShare, OnlyWherePointsAre) {
  Scene scene = PlaneScene(3, 1e-4, 2.0);
  std::erase_if(scene.points, [](const SparsePoint& point) { return point.x_in_world.x() > 0; });
  const SurfaceShare share = EstimateSurfaceShare(scene);
  // Up to two of the 24 cells beyond.
  EXPECT_NEAR(share.covered, 0.5 + 2.0 / 24, 0.05);
}

TEST(EstimateSurfaceShare, IsInvariantToScaleAndTurn) {
  const Scene scene = PlaneScene(4, 0.3, 2.0);
  Scene other = scene;
  const Rigid3 moved_from_world(Eigen::Quaterniond(0.3, 0.5, -0.2, 0.9), {10, -5, 7});
  constexpr double kScale = 12.0;
  for (SparsePoint& point : other.points) {
    point.x_in_world = moved_from_world * (kScale * point.x_in_world);
  }
  for (View& view : other.views) {
    view.cam_from_world.translation *= kScale;
    view.cam_from_world = view.cam_from_world * moved_from_world.Inverse();
  }
  EXPECT_NEAR(EstimateSurfaceShare(other).once, EstimateSurfaceShare(scene).once, 1e-9);
}

TEST(EstimateSurfaceShare, WithoutPointsTheUsual) {
  EXPECT_EQ(EstimateSurfaceShare(Scene()).once, SurfaceShare().once);
  Scene scene = PlaneScene(3, 1.0, 2.0);
  scene.points.clear();
  EXPECT_EQ(EstimateSurfaceShare(scene).covered, SurfaceShare().covered);
  EXPECT_EQ(EstimateSurfaceShare(scene).once, SurfaceShare().once);
}

// A plan must not wait: some of many photos tell as much as all.
TEST(EstimateSurfaceShare, OfManyPhotosSomeAreEnough) {
  constexpr int kNumViews = 19, kNumCopies = 41;
  Scene scene = PlaneScene(kNumViews, 0.02, 2.0);
  std::vector<SparsePoint> points;
  for (size_t p = 0; p < scene.points.size(); p += 10) points.push_back(scene.points[p]);
  scene.points = points;
  const SurfaceShare once = EstimateSurfaceShare(scene);
  const std::vector<View> views = scene.views;
  for (int copy = 1; copy < kNumCopies; ++copy) {
    scene.views.insert(scene.views.end(), views.begin(), views.end());
    for (size_t p = 0; p < points.size(); ++p) {
      for (const int v : points[p].view_idxs) {
        scene.points[p].view_idxs.push_back(copy * kNumViews + v);
      }
    }
  }
  const SurfaceShare many = EstimateSurfaceShare(scene);
  EXPECT_NEAR(many.covered, once.covered, 0.05);
  EXPECT_NEAR(many.once * kNumCopies, once.once, 0.1 * once.once);
}

}  // namespace
}  // namespace lsmvs
