#include "lsmvs/stereo/fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/truth.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

// True depth maps with their photos, optionally with noise on the depths.
struct TrueMaps {
  explicit TrueMaps(ShapeName shape) {
    SyntheticSceneOptions options;
    options.shape = shape;
    options.num_views = 6;
    options.width = 120;
    options.height = 90;
    options.layout = CameraLayout::kArc;
    synthetic = MakeScene(options, RunContext(1));
    WritePhotos(*synthetic.shape, synthetic.photo, folder.path().string(), &synthetic.scene,
                RunContext(1));
    images = MakeImageStore(scene(), {});
    neighbors = SelectNeighbors(scene(), {});
    for (const View& view : scene().views) {
      maps.push_back(TrueDepthMap(*synthetic.shape, view, RunContext(1)));
    }
  }
  const Scene& scene() const { return synthetic.scene; }
  VisibilityCloud Fuse(const FusionOptions& options, int threads = 1) const {
    return FuseDepthMaps(scene(), *images, neighbors, MemoryDepthMaps(maps), options,
                         RunContext(threads));
  }
  void AddNoise(double sigma_gsd) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, sigma_gsd * synthetic.gsd);
    for (DepthMap& map : maps) {
      for (float& depth : map.depth.pixels) {
        if (depth > 0) depth += static_cast<float>(noise(random));
      }
    }
  }

  TemporaryFolder folder;
  SyntheticScene synthetic;
  std::unique_ptr<ImageStore> images;
  std::vector<std::vector<Neighbor>> neighbors;
  std::vector<DepthMap> maps;
};

TEST(FuseDepthMaps, PutsPointsOnTheTrueSurface) {
  const TrueMaps input(ShapeName::kRelief);
  const VisibilityCloud cloud = input.Fuse({});
  cloud.CheckConsistent(input.scene().views.size());
  ASSERT_GT(cloud.size(), 5000u);
  const SurfaceError error = MeasureCloud(cloud, input.synthetic);
  EXPECT_LT(error.mean, 0.05 * input.synthetic.gsd);
  EXPECT_LT(error.p95, 0.2 * input.synthetic.gsd);
  EXPECT_LT(std::abs(error.bias), 0.02 * input.synthetic.gsd);
}

TEST(FuseDepthMaps, ListsViewsThatSeeThePoint) {
  const TrueMaps input(ShapeName::kSphereOnGround);
  const VisibilityCloud cloud = input.Fuse({});
  ASSERT_GT(cloud.size(), 1000u);
  size_t num_seen = 0, num_listed = 0;
  for (size_t p = 0; p < cloud.size(); p += 7) {
    EXPECT_GE(cloud.ViewsOf(p).size(), 3u);
    EXPECT_NEAR(cloud.normals[p].norm(), 1.0f, 1e-5f);
    for (const uint32_t v : cloud.ViewsOf(p)) {
      const View& view = input.scene().views[v];
      const Eigen::Vector3d x = view.cam_from_world * cloud.positions[p].cast<double>();
      EXPECT_TRUE(view.camera.Contains(view.camera.Project(x)));
      ++num_listed;
      num_seen += SeesSurfacePoint(*input.synthetic.shape, view,
                                   cloud.positions[p].cast<double>() +
                                       0.1 * input.synthetic.gsd * cloud.normals[p].cast<double>(),
                                   cloud.normals[p].cast<double>(), 88.0);
    }
  }
  EXPECT_GT(static_cast<double>(num_seen), 0.98 * static_cast<double>(num_listed));
}

TEST(FuseDepthMaps, AveragesNoiseAway) {
  TrueMaps input(ShapeName::kStep);
  FusionOptions options;
  options.min_num_pixels = 5;
  input.AddNoise(1.0);
  const SurfaceError error = MeasureCloud(input.Fuse(options), input.synthetic);
  // A single map has a mean error of 0.8 (before the obliquity of the rays lowers it).
  EXPECT_LT(error.mean, 0.45 * input.synthetic.gsd);
  EXPECT_LT(std::abs(error.bias), 0.05 * input.synthetic.gsd);
}

TEST(FuseDepthMaps, DropsWhatViewsDoNotAgreeOn) {
  TrueMaps input(ShapeName::kStep);
  for (float& depth : input.maps[2].depth.pixels) depth *= 1.2f;
  const SurfaceError error = MeasureCloud(input.Fuse({}), input.synthetic);
  EXPECT_LT(error.max, 2 * input.synthetic.gsd);
  for (DepthMap& map : input.maps) map.normal.pixels.assign(map.normal.size(), {0, 0, -1});
  FusionOptions options;
  options.max_normal_error = 1;
  EXPECT_LT(input.Fuse(options).size(), 100u);
}

TEST(FuseDepthMaps, HasNoMorePointsThanItNeeds) {
  const TrueMaps input(ShapeName::kStep);
  size_t num_depths = 0;
  for (const DepthMap& map : input.maps) {
    for (const float depth : map.depth.pixels) num_depths += depth > 0;
  }
  EXPECT_LT(input.Fuse({}).size(), num_depths / 2);
}

TEST(FuseDepthMaps, RespectsBoundingBoxMasksAndMissingMaps) {
  TrueMaps input(ShapeName::kStep);
  FusionOptions options;
  options.bounding_box = {Eigen::Vector3d(-0.5, -0.5, -1), Eigen::Vector3d(0.5, 0.5, 1)};
  const VisibilityCloud cloud = input.Fuse(options);
  ASSERT_GT(cloud.size(), 100u);
  for (const Eigen::Vector3f& x : cloud.positions) {
    EXPECT_TRUE(options.bounding_box.contains(x.cast<double>()));
  }
  input.maps[0].depth.pixels.assign(input.maps[0].depth.size(), 0.0f);
  const VisibilityCloud fewer = input.Fuse({});
  EXPECT_EQ(std::count(fewer.view_idxs.begin(), fewer.view_idxs.end(), 0u), 0);
}

TEST(FuseDepthMaps, DoesNotDependOnThreads) {
  TrueMaps input(ShapeName::kRelief);
  input.AddNoise(0.5);
  const VisibilityCloud one = input.Fuse({}, 1), two = input.Fuse({}, 2);
  EXPECT_EQ(one.positions, two.positions);
  EXPECT_EQ(one.normals, two.normals);
  EXPECT_EQ(one.colors, two.colors);
  EXPECT_EQ(one.view_begin, two.view_begin);
  EXPECT_EQ(one.view_idxs, two.view_idxs);
}

TEST(FusionOptions, HaveValidDefaultsAndNameWhatIsOutOfBounds) {
  FusionOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  const auto expect_refused = [](auto FusionOptions::*field, auto value, const char* name) {
    FusionOptions bad;
    bad.*field = value;
    std::string message;
    EXPECT_FALSE(bad.Check(&message)) << name;
    EXPECT_NE(message.find(name), std::string::npos) << message;
  };
  expect_refused(&FusionOptions::min_num_pixels, 0, "min_num_pixels");
  expect_refused(&FusionOptions::max_num_pixels, 0, "max_num_pixels");
  expect_refused(&FusionOptions::max_reproj_error, -1.0, "max_reproj_error");
  expect_refused(&FusionOptions::max_depth_error, 2.0, "max_depth_error");
  expect_refused(&FusionOptions::max_normal_error, 181.0, "max_normal_error");
  expect_refused(&FusionOptions::check_num_images, 0, "check_num_images");
}

}  // namespace
}  // namespace lsmvs
