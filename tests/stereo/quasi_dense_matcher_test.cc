#include "lsmvs/stereo/quasi_dense_matcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/synthetic/texture.h"
#include "lsmvs/test_stereo/quasi_dense_scene.h"
#include "lsmvs/util/error.h"

namespace lsmvs::quasi_dense {
namespace {

struct Matched : QuasiDenseResult {
  VisibilityCloud cloud;  // all that went to the sink
};

// What MatchQuasiDense says and gives.
Matched MatchAll(const Scene& scene, const ImageStore& images,
                 const std::vector<std::vector<Neighbor>>& neighbors,
                 std::span<const std::vector<Eigen::Vector2f>> keypoints,
                 const QuasiDenseOptions& options, const RunContext& context) {
  Matched matched;
  const auto append = [&](const VisibilityCloud& part) {
    for (size_t p = 0; p < part.size(); ++p) {
      matched.cloud.Add(part.positions[p], part.normals[p], part.colors[p], part.ViewsOf(p));
    }
  };
  static_cast<QuasiDenseResult&>(matched) =
      MatchQuasiDense(scene, images, neighbors, keypoints, options, append, context);
  EXPECT_EQ(matched.num_points, matched.cloud.size());
  EXPECT_EQ(matched.num_observations, matched.cloud.view_idxs.size());
  return matched;
}

Matched Match(const PhotoScene& scene, const QuasiDenseOptions& options = {}, int num_threads = 2) {
  return MatchAll(scene.synthetic.scene, *scene.images, scene.neighbors, {}, options,
                  RunContext(num_threads));
}

// Matched once.
const VisibilityCloud& SphereCloud() {
  static const Matched result = Match(SphereScene());
  return result.cloud;
}
const VisibilityCloud& ReliefCloud() {
  static const Matched result = Match(ReliefScene());
  return result.cloud;
}

// Mean signed distance of the points within two pixels of the surface.
double BiasOfInliers(const VisibilityCloud& cloud, const PhotoScene& scene) {
  double total = 0;
  size_t count = 0;
  for (const Eigen::Vector3f& x : cloud.positions) {
    const double distance = scene.synthetic.shape->SignedDistance(x.cast<double>());
    if (std::abs(distance) > 2 * scene.synthetic.gsd) continue;
    total += distance;
    ++count;
  }
  return total / static_cast<double>(count);
}

void ExpectAccurate(const VisibilityCloud& cloud, const PhotoScene& scene) {
  const SurfaceError error = MeasureCloud(cloud, scene.synthetic);
  const double gsd = scene.synthetic.gsd;
  EXPECT_GT(error.Within(0.5 * gsd), 0.5) << "median above half a pixel";
  EXPECT_GT(error.Within(2 * gsd), 0.95);
  EXPECT_LT(std::abs(BiasOfInliers(cloud, scene)), 0.1 * gsd);
}

TEST(QuasiDenseMatcher, PointsLieOnTheSphere) {
  ASSERT_GT(SphereCloud().size(), 2500u);
  SphereCloud().CheckConsistent(SphereScene().synthetic.scene.views.size());
  ExpectAccurate(SphereCloud(), SphereScene());
}

TEST(QuasiDenseMatcher, PointsLieOnTheRelief) {
  ASSERT_GT(ReliefCloud().size(), 4000u);
  ExpectAccurate(ReliefCloud(), ReliefScene());
}

TEST(QuasiDenseMatcher, NormalsAreThoseOfTheSurface) {
  std::vector<double> angles_deg;
  const VisibilityCloud& cloud = SphereCloud();
  for (size_t p = 0; p < cloud.size(); ++p) {
    EXPECT_NEAR(cloud.normals[p].norm(), 1, 1e-4);
    const Eigen::Vector3d truth =
        SphereScene().synthetic.shape->Closest(cloud.positions[p].cast<double>()).normal;
    angles_deg.push_back(
        std::acos(std::clamp(truth.dot(cloud.normals[p].cast<double>()), -1.0, 1.0)) * 180 / M_PI);
  }
  std::sort(angles_deg.begin(), angles_deg.end());
  EXPECT_LT(angles_deg[angles_deg.size() / 2], 10);
  EXPECT_LT(angles_deg[angles_deg.size() * 9 / 10], 30);
}

// The views listed see the point (but near edges, which windows blur: many in so small photos), and
// most views that see a point are listed.
TEST(QuasiDenseMatcher, ViewsAreThoseThatSeeThePoint) {
  for (const auto& [cloud, photos] :
       {std::pair(&SphereCloud(), &SphereScene()), std::pair(&ReliefCloud(), &ReliefScene())}) {
    const Shape& shape = *photos->synthetic.shape;
    const Scene& scene = photos->synthetic.scene;
    size_t num_listed = 0, num_right = 0, num_seeing = 0;
    for (size_t p = 0; p < cloud->size(); p += 3) {
      const SurfacePoint truth = shape.Closest(cloud->positions[p].cast<double>());
      if (std::abs(truth.signed_distance) > 2 * photos->synthetic.gsd) continue;
      // A little above the surface, so that a point beside an edge is not taken for hidden.
      const Eigen::Vector3d x = truth.position + 0.5 * photos->synthetic.gsd * truth.normal;
      std::vector<bool> sees;
      for (const View& view : scene.views) {
        sees.push_back(SeesSurfacePoint(shape, view, x, truth.normal, 85));
        num_seeing += sees.back();
      }
      for (const uint32_t v : cloud->ViewsOf(p)) num_right += sees[v];
      num_listed += cloud->ViewsOf(p).size();
      EXPECT_GE(cloud->ViewsOf(p).size(), 2u);
    }
    EXPECT_GT(static_cast<double>(num_right), 0.9 * static_cast<double>(num_listed));
    EXPECT_GT(static_cast<double>(num_right), 0.4 * static_cast<double>(num_seeing));
  }
}

// Random points of the surface that three views see have a point of the cloud nearby.
TEST(QuasiDenseMatcher, CoversTheSurface) {
  const PhotoScene& photos = ReliefScene();
  int num_points = 0, num_covered = 0;
  for (const SparsePoint& point : photos.synthetic.scene.points) {
    if (point.view_idxs.size() < 3 || ++num_points > 300) continue;
    const double reach = 4 * photos.synthetic.gsd;
    num_covered +=
        std::any_of(ReliefCloud().positions.begin(), ReliefCloud().positions.end(),
                    [&](const Eigen::Vector3f& x) {
                      return (x.cast<double>() - point.x_in_world).squaredNorm() < reach * reach;
                    });
  }
  num_points = std::min(num_points, 300);
  ASSERT_GT(num_points, 100);
  EXPECT_GT(num_covered, 0.85 * num_points);
}

TEST(QuasiDenseMatcher, SameBytesForAnyNumberOfThreads) {
  const Matched one = Match(SphereScene(), {}, 1);
  const VisibilityCloud& two = SphereCloud();
  ASSERT_EQ(one.cloud.size(), two.size());
  EXPECT_EQ(one.cloud.positions, two.positions);
  EXPECT_EQ(one.cloud.normals, two.normals);
  EXPECT_EQ(one.cloud.colors, two.colors);
  EXPECT_EQ(one.cloud.view_begin, two.view_begin);
  EXPECT_EQ(one.cloud.view_idxs, two.view_idxs);
}

TEST(QuasiDenseMatcher, CountersAndPhasesAddUp) {
  const Matched result = Match(SphereScene());
  const QuasiDenseCounters& counters = result.counters;
  EXPECT_EQ(result.status, QuasiDenseStatus::kSuccess);
  EXPECT_THAT(result.message, testing::HasSubstr("points"));
  EXPECT_GE(counters.num_interest_points, counters.num_matched);
  EXPECT_GE(counters.num_matched, counters.num_tracks);
  EXPECT_EQ(counters.num_tracks, result.cloud.size() + counters.num_dropped_angle +
                                     counters.num_dropped_error + counters.num_dropped_cheirality +
                                     counters.num_dropped_outside);
  EXPECT_GT(counters.num_patches, counters.num_interest_points);
  EXPECT_FALSE(result.seconds.empty());
}

// The scene's unit does not matter: positions scale with it.
TEST(QuasiDenseMatcher, DoesNotDependOnTheUnit) {
  constexpr double kScale = 1024;
  const PhotoScene& photos = SphereScene();
  Scene large = photos.synthetic.scene;
  for (View& view : large.views) view.cam_from_world.translation *= kScale;
  for (SparsePoint& point : large.points) point.x_in_world *= kScale;
  const Matched result = MatchAll(large, *photos.images, photos.neighbors, {}, {}, RunContext(2));
  ASSERT_NEAR(static_cast<double>(result.cloud.size()), static_cast<double>(SphereCloud().size()),
              0.002 * static_cast<double>(SphereCloud().size()));
  double worst = 0;
  for (const Eigen::Vector3f& x : result.cloud.positions) {
    const double distance = photos.synthetic.shape->SignedDistance(x.cast<double>() / kScale);
    worst += std::abs(distance);
  }
  EXPECT_LT(worst / static_cast<double>(result.cloud.size()), 0.5 * photos.synthetic.gsd);
}

TEST(QuasiDenseMatcher, MasksAndBoxesKeepOut) {
  const PhotoScene& photos = SphereScene();
  QuasiDenseOptions options;
  options.bounding_box = Eigen::AlignedBox3d(Eigen::Vector3d(-2, -2, 0), Eigen::Vector3d(2, 2, 2));
  const Matched boxed = Match(photos, options);
  ASSERT_GT(boxed.cloud.size(), 800u);
  EXPECT_GT(boxed.counters.num_dropped_outside, 100u);
  for (const Eigen::Vector3f& x : boxed.cloud.positions) EXPECT_GE(x.z(), 0);

  // Half of every photo is masked.
  const TemporaryFolder masks;
  Scene scene = photos.synthetic.scene;
  scene.mask_folder = masks.path().string();
  for (const View& view : scene.views) {
    ColorImage mask(view.camera.width, view.camera.height, Color(255, 255, 255));
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width / 2; ++x) mask(x, y) = Color(0, 0, 0);
    }
    WriteImage((masks.path() / (view.name + ".png")).string(), mask);
  }
  const auto images = MakeImageStore(scene, {});
  const Matched masked = MatchAll(scene, *images, photos.neighbors, {}, {}, RunContext(2));
  EXPECT_GT(masked.cloud.size(), 300u);
  EXPECT_LT(masked.counters.num_interest_points, SphereCloud().size() * 3);
  for (size_t p = 0; p < masked.cloud.size(); ++p) {
    // At least two of its views see it in the half that counts.
    int num_inside = 0;
    for (const uint32_t v : masked.cloud.ViewsOf(p)) {
      const View& view = scene.views[v];
      const Eigen::Vector2d x =
          view.camera.Project(view.cam_from_world * masked.cloud.positions[p].cast<double>());
      num_inside += x.x() > view.camera.width / 2.0 - 6;
    }
    EXPECT_GE(num_inside, 2);
  }
}

TEST(QuasiDenseMatcher, KeypointsJoin) {
  const PhotoScene& photos = SphereScene();
  std::vector<std::vector<Eigen::Vector2f>> keypoints(photos.synthetic.scene.views.size());
  for (auto& list : keypoints) list = {{100.25f, 75.75f}, {90.5f, 70.5f}};
  const Matched result = MatchAll(photos.synthetic.scene, *photos.images, photos.neighbors,
                                  keypoints, {}, RunContext(2));
  // Views without neighbours take part in nothing.
  EXPECT_GT(result.counters.num_joined_keypoints, keypoints.size());
  EXPECT_EQ(result.counters.num_joined_keypoints % 2, 0u);
  ExpectAccurate(result.cloud, photos);
}

TEST(QuasiDenseMatcher, NoNeighborsNoPoints) {
  const PhotoScene& photos = SphereScene();
  const std::vector<std::vector<Neighbor>> none(photos.synthetic.scene.views.size());
  const Matched result =
      MatchAll(photos.synthetic.scene, *photos.images, none, {}, {}, RunContext(1));
  EXPECT_EQ(result.status, QuasiDenseStatus::kNoNeighbors);
  EXPECT_EQ(result.cloud.size(), 0u);
  EXPECT_FALSE(result.message.empty());

  const Scene empty;
  const auto images = MakeImageStore(empty, {});
  EXPECT_EQ(MatchAll(empty, *images, {}, {}, {}, RunContext(1)).status,
            QuasiDenseStatus::kNoNeighbors);
}

TEST(QuasiDenseMatcher, WithoutSparsePointsTheRangeMustBeGiven) {
  const PhotoScene& photos = SphereScene();
  Scene scene = photos.synthetic.scene;
  scene.points.clear();
  const auto match = [&](const QuasiDenseOptions& options) {
    return MatchAll(scene, *photos.images, photos.neighbors, {}, options, RunContext(2));
  };
  EXPECT_EQ(match({}).status, QuasiDenseStatus::kNoDepthRange);
  QuasiDenseOptions options;
  const std::vector<DepthRange> ranges = EstimateDepthRanges(photos.synthetic.scene);
  options.depth_min = ranges[0].min;
  options.depth_max = ranges[0].max;
  const Matched result = match(options);
  EXPECT_EQ(result.status, QuasiDenseStatus::kSuccess);
  ExpectAccurate(result.cloud, photos);
}

TEST(QuasiDenseMatcher, TexturelessPhotosMatchNothing) {
  const PhotoScene& photos = SphereScene();
  const TemporaryFolder folder;
  Scene scene = photos.synthetic.scene;
  scene.image_folder = folder.path().string();
  for (const View& view : scene.views) {
    WriteImage((folder.path() / view.name).string(),
               ColorImage(view.camera.width, view.camera.height, Color(90, 90, 90)));
  }
  const auto images = MakeImageStore(scene, {});
  const Matched result = MatchAll(scene, *images, photos.neighbors, {}, {}, RunContext(2));
  EXPECT_EQ(result.status, QuasiDenseStatus::kNoMatches);
  EXPECT_EQ(result.cloud.size(), 0u);
  EXPECT_EQ(result.counters.num_interest_points, 0u);
}

TEST(QuasiDenseMatcher, ReducedScalesStillWork) {
  QuasiDenseOptions options;
  options.finest_level = 1;
  const Matched half = Match(ReliefScene(), options);
  EXPECT_GT(half.cloud.size(), 800u);
  EXPECT_GT(
      MeasureCloud(half.cloud, ReliefScene().synthetic).Within(4 * ReliefScene().synthetic.gsd),
      0.95);
  options.finest_level = 0;
  options.spacing_px = 6;
  options.num_scales = 1;  // the sweep over the whole range at full size
  ExpectAccurate(Match(ReliefScene(), options).cloud, ReliefScene());
}

TEST(QuasiDenseMatcher, MemoryBudgetDoesNotChangeTheResult) {
  RunContext context(2);
  context.memory_budget_bytes = 1 << 16;  // less than one grid
  const PhotoScene& photos = ReliefScene();
  const VisibilityCloud cloud =
      MatchAll(photos.synthetic.scene, *photos.images, photos.neighbors, {}, {}, context).cloud;
  EXPECT_EQ(cloud.positions, ReliefCloud().positions);
  EXPECT_EQ(cloud.normals, ReliefCloud().normals);
  EXPECT_EQ(cloud.view_idxs, ReliefCloud().view_idxs);
}

TEST(QuasiDenseMatcher, StopsWhenCancelled) {
  const std::atomic<bool> cancel = true;
  RunContext context(2);
  context.cancel = &cancel;
  const PhotoScene& photos = SphereScene();
  EXPECT_THROW(MatchAll(photos.synthetic.scene, *photos.images, photos.neighbors, {}, {}, context),
               CancelledError);
}

TEST(QuasiDenseMatcher, MissingPhotosAreInputErrors) {
  const PhotoScene& photos = SphereScene();
  Scene scene = photos.synthetic.scene;
  scene.image_folder = "/nonexistent";
  const auto images = MakeImageStore(scene, {});
  EXPECT_THROW(MatchAll(scene, *images, photos.neighbors, {}, {}, RunContext(2)), InputError);
}

TEST(QuasiDenseMatcher, ProgressGrowsToOne) {
  struct Sink : ProgressSink {
    void Report(double fraction) override {
      EXPECT_GE(fraction, last);
      last = fraction;
    }
    double last = 0;
  } sink;
  RunContext context(2);
  context.set_progress(&sink);
  const PhotoScene& photos = SphereScene();
  QuasiDenseOptions options;
  options.spacing_px = 6;
  MatchAll(photos.synthetic.scene, *photos.images, photos.neighbors, {}, options, context);
  EXPECT_EQ(sink.last, 1);
}

TEST(QuasiDenseOptions, DefaultsAreValid) {
  std::string error;
  EXPECT_TRUE(QuasiDenseOptions().Check(&error)) << error;
}

TEST(QuasiDenseOptions, EachBoundIsChecked) {
  const auto expect_refused = [](const std::string& field, const auto& change) {
    QuasiDenseOptions options;
    change(&options);
    std::string error;
    EXPECT_FALSE(options.Check(&error)) << field;
    EXPECT_THAT(error, testing::HasSubstr("QuasiDenseMatching." + field));
    const PhotoScene& photos = SphereScene();
    EXPECT_THROW(MatchAll(photos.synthetic.scene, *photos.images, photos.neighbors, {}, options,
                          RunContext(1)),
                 UsageError);
  };
  expect_refused("spacing_px", [](auto* o) { o->spacing_px = 0.5; });
  expect_refused("window_radius", [](auto* o) { o->window_radius = 0; });
  expect_refused("window_radius", [](auto* o) { o->window_radius = 8; });
  expect_refused("finest_level", [](auto* o) { o->finest_level = -1; });
  expect_refused("num_scales", [](auto* o) { o->num_scales = 0; });
  expect_refused("noise_sigma", [](auto* o) { o->noise_sigma = 0; });
  expect_refused("max_num_neighbors", [](auto* o) { o->max_num_neighbors = 0; });
  expect_refused("max_num_fine_neighbors", [](auto* o) { o->max_num_fine_neighbors = 17; });
  expect_refused("min_ncc", [](auto* o) { o->min_ncc = 1.1; });
  expect_refused("max_mutual_error_px", [](auto* o) { o->max_mutual_error_px = -1; });
  expect_refused("min_num_views", [](auto* o) { o->min_num_views = 1; });
  expect_refused("max_reproj_error_px", [](auto* o) { o->max_reproj_error_px = -0.1; });
  expect_refused("loss_scale_px", [](auto* o) { o->loss_scale_px = 0; });
  expect_refused("min_triangulation_angle_deg",
                 [](auto* o) { o->min_triangulation_angle_deg = 91; });
  expect_refused("depth_min", [](auto* o) { o->depth_min = 0; });
  expect_refused("depth_max", [](auto* o) { o->depth_max = -1; });
}

TEST(QuasiDenseCost, GrowsWithPixelsAndDensity) {
  const PhotoScene& photos = SphereScene();
  const auto cost = [&](const QuasiDenseOptions& options) {
    return EstimateQuasiDenseCost(photos.synthetic.scene, *photos.images, options);
  };
  QuasiDenseOptions sparse, half;
  sparse.spacing_px = 5;
  half.finest_level = 1;
  EXPECT_GT(cost({}).cpu_seconds, 2 * cost(sparse).cpu_seconds);
  EXPECT_NEAR(cost({}).cpu_seconds, 4 * cost(half).cpu_seconds, 0.2 * cost({}).cpu_seconds);
  EXPECT_GT(cost({}).peak_bytes, cost(half).peak_bytes);
}

}  // namespace
}  // namespace lsmvs::quasi_dense
