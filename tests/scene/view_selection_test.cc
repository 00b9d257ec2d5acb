#include "lsmvs/scene/view_selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "lsmvs/geometry/triangulation.h"
#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/util/memory.h"

namespace lsmvs {
namespace {

// Cameras on a circle around a sphere, `step_deg` apart.
Scene RingScene(int count, double sweep_deg, double distance_of_last = 1.0) {
  const SyntheticScene s = MakeScene(ShapeName::kSphere, 2, 320, 240);
  Scene scene;
  auto centers = RingCenters({0, 0, 0}, 4.0, 1.0, count, 0, sweep_deg);
  centers.back() *= distance_of_last;
  for (const Eigen::Vector3d& center : centers) {
    scene.views.push_back(
        MakeView(scene.num_views(), MakeCamera(320, 240), LookAt(center, {0, 0, 0})));
  }
  scene.points = SampleSparsePoints(*s.shape, scene, 1500, 0.0, 1, RunContext());
  return scene;
}

std::vector<int> ViewsOf(const std::vector<Neighbor>& neighbors) {
  std::vector<int> views;
  for (const Neighbor& n : neighbors) views.push_back(n.view_idx);
  return views;
}

TEST(SelectNeighbors, PrefersTheAngleAskedFor) {
  const Scene scene = RingScene(19, 90.0);  // 5 degrees apart, with reserve at both ends
  ViewSelectionOptions options;
  for (const int best : {5, 10, 20}) {
    options.best_triangulation_angle_deg = best;
    const auto neighbors = SelectNeighbors(scene, options, RunContext(2));
    // Angles at the surface are larger than at the sphere's middle: by 4 / 3 where it is nearest.
    const double angle = neighbors[9][0].median_angle_deg;
    EXPECT_GT(angle, 0.7 * best);
    EXPECT_LT(angle, 1.5 * best);
  }
}

TEST(SelectNeighbors, CountsSharedPointsAndTheirMedianAngle) {
  const Scene scene = RingScene(8, 360.0);
  ViewSelectionOptions options;
  options.max_triangulation_angle_deg = 180;
  const auto all = SelectNeighbors(scene, options, RunContext(2));
  for (int v = 0; v < scene.num_views(); ++v) {
    for (const Neighbor& n : all[v]) {
      std::vector<double> angles;
      for (const SparsePoint& point : scene.points) {
        const auto& views = point.view_idxs;
        if (std::count(views.begin(), views.end(), v) == 0) continue;
        if (std::count(views.begin(), views.end(), n.view_idx) == 0) continue;
        angles.push_back(TriangulationAngle(scene.views[v].CenterInWorld(),
                                            scene.views[n.view_idx].CenterInWorld(),
                                            point.x_in_world) *
                         180 / std::numbers::pi);
      }
      std::sort(angles.begin(), angles.end());
      EXPECT_EQ(n.num_shared_points, static_cast<int>(angles.size()));
      EXPECT_NEAR(n.median_angle_deg, angles[angles.size() / 2], 1e-3);
    }
  }
}

TEST(SelectNeighbors, ScoreIsTheSumOfItsDefinition) {
  const Scene scene = RingScene(5, 60.0, 2.0);
  constexpr double kBestDeg = 12.0;
  ASSERT_EQ(ViewSelectionOptions().best_triangulation_angle_deg, kBestDeg);
  const auto all = SelectNeighbors(scene, {}, RunContext(2));
  const auto footprint = [&](int v, const Eigen::Vector3d& x) {
    return (scene.views[v].cam_from_world * x).z() / scene.views[v].camera.fx;
  };
  for (int v = 0; v < scene.num_views(); ++v) {
    ASSERT_FALSE(all[v].empty());
    for (const Neighbor& n : all[v]) {
      double sum = 0;
      std::set<std::pair<int, int>> cells;
      for (const SparsePoint& point : scene.points) {
        const auto& views = point.view_idxs;
        if (std::count(views.begin(), views.end(), v) == 0) continue;
        if (std::count(views.begin(), views.end(), n.view_idx) == 0) continue;
        const Eigen::Vector3d& x = point.x_in_world;
        const double angle_deg = TriangulationAngle(scene.views[v].CenterInWorld(),
                                                    scene.views[n.view_idx].CenterInWorld(), x) *
                                 180 / std::numbers::pi;
        const double scale = footprint(v, x) / footprint(n.view_idx, x);
        sum += std::pow(std::min(angle_deg / kBestDeg, kBestDeg / angle_deg), 1.5) *
               std::min(scale, 1 / scale);
        const Eigen::Vector2d x_px =
            scene.views[v].camera.Project(scene.views[v].cam_from_world * x);
        cells.insert({static_cast<int>(x_px.x() / 40), static_cast<int>(x_px.y() / 30)});
      }
      EXPECT_NEAR(n.score, sum * static_cast<double>(cells.size()) / 64, 1e-9 * sum);
    }
  }
}

// Many photos that all see the same: memory grows with what one photo shares, not with all pairs
// (which would be 300 MB here).
TEST(SelectNeighbors, MemoryIsThatOfOneViewAThread) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "memory is counted without sanitizers";
#endif
  constexpr int kNumViews = 400, kNumPoints = 200;
  Scene scene = RingScene(kNumViews, 20.0);
  scene.points.resize(kNumPoints);
  for (SparsePoint& point : scene.points) {
    point.view_idxs.resize(kNumViews);
    std::iota(point.view_idxs.begin(), point.view_idxs.end(), 0);
  }
  const PeakMemoryWatch memory;
  const auto neighbors = SelectNeighbors(scene, {}, RunContext(2));
  EXPECT_EQ(neighbors[0].size(), 8u);
  EXPECT_LT(memory.PeakBytes() - memory.bytes_before(), size_t{8} << 20);
}

TEST(SelectNeighbors, ScoresAreSortedAndLimited) {
  const Scene scene = RingScene(16, 360.0);
  ViewSelectionOptions options;
  options.max_num_neighbors = 3;
  for (const auto& neighbors : SelectNeighbors(scene, options, RunContext(2))) {
    EXPECT_EQ(neighbors.size(), 3u);
    EXPECT_TRUE(std::is_sorted(neighbors.begin(), neighbors.end(),
                               [](const auto& a, const auto& b) { return a.score > b.score; }));
  }
}

TEST(SelectNeighbors, KeepsToTheAngleLimits) {
  const Scene scene = RingScene(12, 110.0);
  ViewSelectionOptions options;
  options.max_num_neighbors = 50;
  options.min_triangulation_angle_deg = 15;
  options.max_triangulation_angle_deg = 40;
  int count = 0;
  for (const auto& neighbors : SelectNeighbors(scene, options, RunContext(2))) {
    for (const Neighbor& n : neighbors) {
      EXPECT_GE(n.median_angle_deg, 15);
      EXPECT_LE(n.median_angle_deg, 40);
      ++count;
    }
  }
  EXPECT_GT(count, 12);
}

TEST(SelectNeighbors, OtherScaleScoresLess) {
  // Views 0 and 2 stand 12 degrees to both sides of view 1; view 2 three times as far away.
  const Scene scene = RingScene(3, 24.0, 3.0);
  const auto neighbors = SelectNeighbors(scene, ViewSelectionOptions(), RunContext(2));
  EXPECT_EQ(ViewsOf(neighbors[1]), (std::vector<int>{0, 2}));
  EXPECT_LT(neighbors[1][1].score, 0.6 * neighbors[1][0].score);
}

TEST(SelectNeighbors, TooFewSharedPointsAreNotTrusted) {
  Scene scene = RingScene(4, 40.0);
  scene.points.resize(4);
  for (SparsePoint& point : scene.points) point.view_idxs = {0, 1, 2, 3};
  // They may still be neighbours by what they look at.
  for (const auto& neighbors : SelectNeighbors(scene, {}, RunContext(2))) {
    for (const Neighbor& n : neighbors) EXPECT_TRUE(n.by_overlap);
  }
  ViewSelectionOptions lenient;
  lenient.min_num_shared_points = 4;
  const auto neighbors = SelectNeighbors(scene, lenient, RunContext(2));
  ASSERT_FALSE(neighbors[0].empty());
  EXPECT_FALSE(neighbors[0].front().by_overlap);
}

// Soft texture: each point is matched in two adjacent photos only, and in all too few.
TEST(SelectNeighbors, PhotosOfTheSamePlaceThatShareTooFewPointsAreNeighborsByOverlap) {
  constexpr int kNumViews = 16;
  Scene scene = RingScene(kNumViews, 360.0);
  const auto expected = SelectNeighbors(scene, {}, RunContext(2));
  // View 5 takes part in no track, and view 9 in that of one point.
  for (SparsePoint& point : scene.points) std::erase(point.view_idxs, 5);
  for (size_t p = 0; p + 1 < scene.points.size(); ++p) std::erase(scene.points[p].view_idxs, 9);
  const auto neighbors = SelectNeighbors(scene, {}, RunContext(2));
  for (const int v : {5, 9}) {
    EXPECT_EQ(neighbors[v].size(), 4u);
    // Photos that really show the same: those that would be chosen by shared points.
    const std::vector<int> good = ViewsOf(expected[v]);
    for (const Neighbor& n : neighbors[v]) {
      EXPECT_TRUE(n.by_overlap);
      EXPECT_EQ(n.num_shared_points, 0);
      EXPECT_NE(std::find(good.begin(), good.end(), n.view_idx), good.end()) << n.view_idx;
      EXPECT_GE(n.median_angle_deg, ViewSelectionOptions().min_triangulation_angle_deg);
      EXPECT_LE(n.median_angle_deg, ViewSelectionOptions().max_triangulation_angle_deg);
    }
    EXPECT_TRUE(std::is_sorted(neighbors[v].begin(), neighbors[v].end(),
                               [](const auto& a, const auto& b) { return a.score > b.score; }));
  }
  // The others have enough by shared points.
  for (const Neighbor& n : neighbors[0]) EXPECT_FALSE(n.by_overlap);
}

TEST(SelectNeighbors, NeighborsBySharedPointsComeFirst) {
  Scene scene = RingScene(12, 120.0);
  // View 4 shares points with view 3 alone.
  for (SparsePoint& point : scene.points) {
    const bool keep = std::binary_search(point.view_idxs.begin(), point.view_idxs.end(), 3);
    if (!keep) {
      std::erase(point.view_idxs, 4);
    } else if (std::binary_search(point.view_idxs.begin(), point.view_idxs.end(), 4)) {
      point.view_idxs = {3, 4};
    }
  }
  const auto neighbors = SelectNeighbors(scene, {}, RunContext(2))[4];
  ASSERT_EQ(neighbors.size(), 4u);
  EXPECT_EQ(neighbors[0].view_idx, 3);
  EXPECT_FALSE(neighbors[0].by_overlap);
  for (size_t i = 1; i < 4; ++i) {
    EXPECT_TRUE(neighbors[i].by_overlap);
    EXPECT_NE(neighbors[i].view_idx, 3);
    EXPECT_LT(neighbors[i].score, neighbors[0].score);
  }
}

// Views that turn their backs on each other are no neighbours, whatever points lie between.
TEST(SelectNeighbors, OverlapNeedsTheSameSideOfTheSurface) {
  Scene scene = RingScene(8, 360.0);
  scene.views = {scene.views[0], scene.views[4]};
  for (SparsePoint& point : scene.points) {
    const bool seen_by_first =
        std::binary_search(point.view_idxs.begin(), point.view_idxs.end(), 0);
    point.view_idxs = {seen_by_first ? 0 : 1};
  }
  scene.points.front().view_idxs = {0, 1};
  for (const auto& neighbors : SelectNeighbors(scene, {}, RunContext(2))) {
    EXPECT_TRUE(neighbors.empty());
  }
}

TEST(SelectNeighbors, WithoutTracksTheNearestViewsThatLookTheSameWay) {
  Scene scene = RingScene(12, 360.0);  // 30 degrees apart
  scene.points.clear();
  const auto neighbors = SelectNeighbors(scene, ViewSelectionOptions(), RunContext(2));
  for (int v = 0; v < 12; ++v) {
    std::vector<int> views = ViewsOf(neighbors[v]);
    std::sort(views.begin(), views.end());
    std::vector<int> expected = {(v + 1) % 12, (v + 11) % 12};
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(views, expected);
  }
}

// Crops of panoramas with poses only: no depth comes from a crop of the same panorama.
TEST(SelectNeighbors, WithoutTracksNeverFromTheSamePlaceAndThoseThatLookTheSameWayFirst) {
  Scene scene;
  for (int place = 0; place < 4; ++place) {
    for (int crop = 0; crop < 5; ++crop) {
      View view;
      view.cam_from_world.rotation =
          Eigen::AngleAxisd(0.35 * crop, Eigen::Vector3d::UnitY()).toRotationMatrix();
      view.cam_from_world.translation =
          -(view.cam_from_world.rotation * Eigen::Vector3d(place, 0, 1e-9 * crop));
      scene.views.push_back(view);
    }
  }
  const auto neighbors = SelectNeighbors(scene, {}, RunContext(2));
  for (int v = 0; v < 20; ++v) {
    ASSERT_FALSE(neighbors[v].empty());
    EXPECT_EQ(neighbors[v][0].view_idx % 5, v % 5);
    for (const Neighbor& n : neighbors[v]) EXPECT_NE(n.view_idx / 5, v / 5);
  }
}

TEST(SelectNeighbors, IsInvariantToScaleRotationAndTranslation) {
  const Scene scene = RingScene(10, 200.0);
  const Eigen::Quaterniond turn(0.3, 0.5, -0.2, 0.9);
  const Rigid3 moved_from_world(turn, Eigen::Vector3d(100, -50, 7));
  constexpr double kScale = 37.0;
  Scene other = scene;
  for (SparsePoint& point : other.points) {
    point.x_in_world = moved_from_world * (kScale * point.x_in_world);
  }
  for (View& view : other.views) {
    view.cam_from_world.translation *= kScale;
    view.cam_from_world = view.cam_from_world * moved_from_world.Inverse();
  }
  const auto expected = SelectNeighbors(scene, ViewSelectionOptions(), RunContext(2));
  const auto found = SelectNeighbors(other, ViewSelectionOptions(), RunContext(2));
  for (size_t v = 0; v < expected.size(); ++v) {
    ASSERT_EQ(ViewsOf(found[v]), ViewsOf(expected[v]));
    for (size_t i = 0; i < expected[v].size(); ++i) {
      EXPECT_NEAR(found[v][i].score / expected[v][i].score, 1.0, 1e-6);
    }
  }
}

// Adds every view again, `turn_deg` further along the ring, with all the points that it sees.
Scene WithEachViewTwice(Scene scene, double turn_deg) {
  const int count = scene.num_views();
  for (int v = 0; v < count; ++v) {
    View view = scene.views[v];
    const Rigid3 turned(Eigen::Quaterniond(Eigen::AngleAxisd(turn_deg * std::numbers::pi / 180,
                                                             Eigen::Vector3d::UnitZ())),
                        Eigen::Vector3d::Zero());
    view.cam_from_world = view.cam_from_world * turned.Inverse();
    scene.views.push_back(view);
  }
  for (SparsePoint& point : scene.points) {
    const std::vector<int> views = point.view_idxs;
    for (const int v : views) point.view_idxs.push_back(v + count);
  }
  return scene;
}

// Neither the photo that is twice in the model nor bursts take the places of other neighbours.
TEST(SelectNeighbors, PhotosThatShowTheSameCountAsOne) {
  constexpr int kNumViews = 19;
  const Scene once = RingScene(kNumViews, 180.0);
  for (const double turn_deg : {0.0, 0.3}) {
    const auto expected = SelectNeighbors(once, {}, RunContext(2));
    const auto neighbors = SelectNeighbors(WithEachViewTwice(once, turn_deg), {}, RunContext(2));
    for (int v = 0; v < kNumViews; ++v) {
      ASSERT_GE(expected[v].size(), 4u);
      std::set<int> places, expected_places;
      for (const Neighbor& n : neighbors[v]) places.insert(n.view_idx % kNumViews);
      for (const Neighbor& n : expected[v]) expected_places.insert(n.view_idx);
      EXPECT_EQ(places, expected_places) << "turned by " << turn_deg;
    }
  }
}

// Where there are few photos bursts still help, but not a photo that is there twice.
TEST(SelectNeighbors, BurstsComeLastWhereThereAreFewOthers) {
  const Scene once = RingScene(3, 20.0);
  const auto twice = SelectNeighbors(WithEachViewTwice(once, 0.0), {}, RunContext(2));
  EXPECT_EQ(twice[0].size(), 2u);
  const auto bursts = SelectNeighbors(WithEachViewTwice(once, 0.3), {}, RunContext(2))[0];
  ASSERT_EQ(bursts.size(), 4u);
  EXPECT_NE(bursts[0].view_idx % 3, bursts[1].view_idx % 3);
  EXPECT_LE(bursts[2].score, 0.5 * bursts[1].score);
  EXPECT_LE(bursts[3].score, bursts[2].score);
}

// Crops of one panorama show different things: each is a neighbour of its own. So is a photo that
// shows the same larger.
TEST(SelectNeighbors, PhotosFromOnePlaceThatShowOtherThingsAreDistinct) {
  Scene scene = RingScene(4, 30.0);
  View zoomed = scene.views[1];
  zoomed.camera.fx *= 2;
  zoomed.camera.fy *= 2;
  scene.views.push_back(zoomed);
  scene.views.push_back(scene.views[2]);
  for (const auto& [v, angle] : {std::pair{2, -0.4}, std::pair{5, 0.4}}) {
    const Rigid3 turn(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
                      Eigen::Vector3d::Zero());
    scene.views[v].cam_from_world = turn * scene.views[v].cam_from_world;
  }
  for (SparsePoint& point : scene.points) {
    const std::vector<int> before = std::exchange(point.view_idxs, {});
    for (int v = 0; v < 6; ++v) {
      const View& view = scene.views[v];
      const bool unhidden = std::binary_search(before.begin(), before.end(), v < 4 ? v : v - 3);
      if (unhidden &&
          view.camera.Contains(view.camera.Project(view.cam_from_world * point.x_in_world))) {
        point.view_idxs.push_back(v);
      }
    }
  }
  std::vector<int> found = ViewsOf(SelectNeighbors(scene, {}, RunContext(2))[0]);
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (std::vector<int>{1, 2, 3, 4, 5}));
}

TEST(SelectNeighbors, EmptyScenesAndLonelyViews) {
  EXPECT_TRUE(SelectNeighbors(Scene(), ViewSelectionOptions(), RunContext(2)).empty());
  Scene one = RingScene(4, 40.0);
  one.views.resize(1);
  one.points.clear();
  EXPECT_TRUE(SelectNeighbors(one, ViewSelectionOptions(), RunContext(2))[0].empty());
}

TEST(ViewSelectionOptions, DefaultsAreValidAndEachBoundIsKept) {
  std::string error;
  EXPECT_TRUE(ViewSelectionOptions().Check(&error)) << error;
  const auto refuses = [&](auto&& change, const std::string& name) {
    ViewSelectionOptions options;
    change(&options);
    EXPECT_FALSE(options.Check(&error)) << name;
    EXPECT_NE(error.find(name), std::string::npos) << error;
  };
  refuses([](auto* o) { o->max_num_neighbors = 0; }, "max_num_neighbors");
  refuses([](auto* o) { o->min_triangulation_angle_deg = -1; }, "min_triangulation_angle");
  refuses([](auto* o) { o->max_triangulation_angle_deg = 181; }, "max_triangulation_angle");
  refuses([](auto* o) { o->best_triangulation_angle_deg = 0; }, "best_triangulation_angle");
  refuses([](auto* o) { o->min_num_shared_points = 0; }, "min_num_shared_points");
}

// Twenty views that all see 40,000 points: half of the points are looked at, and count twice.
TEST(SelectNeighbors, LooksAtSomeOfThePointsThatManyViewsSee) {
  Scene scene = RingScene(20, 90.0);
  for (SparsePoint& point : scene.points) {
    point.view_idxs.resize(20);
    std::iota(point.view_idxs.begin(), point.view_idxs.end(), 0);
  }
  const size_t num_points = scene.points.size();
  while (scene.points.size() < 40000) {
    SparsePoint point = scene.points[scene.points.size() % num_points];
    point.x_in_world *= 1 + 1e-6 * static_cast<double>(scene.points.size());
    scene.points.push_back(point);
  }
  Scene half = scene;
  half.points.clear();
  for (size_t p = 0; p < scene.points.size(); p += 2) half.points.push_back(scene.points[p]);
  const auto all = SelectNeighbors(scene, {}, RunContext()),
             some = SelectNeighbors(half, {}, RunContext());
  for (size_t v = 0; v < all.size(); ++v) {
    ASSERT_EQ(ViewsOf(all[v]), ViewsOf(some[v]));
    for (size_t n = 0; n < all[v].size(); ++n) {
      EXPECT_NEAR(all[v][n].score, 2 * some[v][n].score, 1e-6 * all[v][n].score);
      EXPECT_EQ(all[v][n].num_shared_points, 2 * some[v][n].num_shared_points);
    }
  }
}

}  // namespace
}  // namespace lsmvs
