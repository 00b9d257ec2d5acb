#include "lsmvs/stereo/fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
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
    neighbors = SelectNeighbors(scene(), {}, RunContext(2));
    for (const View& view : scene().views) {
      maps.push_back(TrueDepthMap(*synthetic.shape, view, RunContext(1)));
    }
  }
  const Scene& scene() const { return synthetic.scene; }
  VisibilityCloud Fuse(const FusionOptions& options, int threads = 1) const {
    VisibilityCloud cloud;
    FuseDepthMaps(
        scene(), *images, neighbors, MemoryDepthMaps(maps), options,
        [&](const VisibilityCloud& part) { cloud.Append(part); }, RunContext(threads));
    return cloud;
  }
  VisibilityCloud FuseOf(const std::vector<int>& view_idxs) const {
    VisibilityCloud cloud;
    FuseViews(
        scene(), *images, neighbors, MemoryDepthMaps(maps), view_idxs, {},
        [&](const VisibilityCloud& part) { cloud.Append(part); }, RunContext(2));
    return cloud;
  }
  void MakeAllNeighbors() {
    for (size_t v = 0; v < maps.size(); ++v) {
      neighbors[v].clear();
      for (int other = 0; other < 6; ++other) {
        if (other != static_cast<int>(v)) neighbors[v].push_back({other, 1.0, 10, 10});
      }
    }
  }
  // The maps of some views as of photos of half the size.
  void Halve(const std::vector<size_t>& view_idxs) {
    for (const size_t v : view_idxs) {
      View view = scene().views[v];
      view.camera = view.camera.Resized(view.camera.width / 2, view.camera.height / 2);
      maps[v] = TrueDepthMap(*synthetic.shape, view, RunContext(1));
    }
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
  FusionOptions options;
  options.weak_max_reproj_error = 0;
  const VisibilityCloud cloud = input.Fuse(options);
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

size_t CountPairs(const VisibilityCloud& cloud) {
  size_t count = 0;
  for (size_t p = 0; p < cloud.size(); ++p) count += cloud.ViewsOf(p).size() == 2;
  return count;
}

// All maps but those of views 2 and 3 are emptied.
void KeepOnePair(TrueMaps* input) {
  for (size_t v = 0; v < input->maps.size(); ++v) {
    if (v != 2 && v != 3) input->maps[v].depth.pixels.assign(input->maps[v].depth.size(), 0.0f);
  }
}

TEST(FuseDepthMaps, TakesWhatAPairSeesWhereNoOtherViewCouldTell) {
  TrueMaps input(ShapeName::kRelief);
  KeepOnePair(&input);
  const VisibilityCloud cloud = input.Fuse({});
  EXPECT_GT(cloud.size(), 3000u);
  EXPECT_EQ(CountPairs(cloud), cloud.size());
  const SurfaceError error = MeasureCloud(cloud, input.synthetic);
  EXPECT_LT(error.p95, 0.2 * input.synthetic.gsd);
  FusionOptions options;
  options.weak_max_reproj_error = 0;
  EXPECT_EQ(input.Fuse(options).size(), 0u);
}

TEST(FuseDepthMaps, DropsWhatAPairSeesWhereAnotherViewSeesThroughIt) {
  TrueMaps input(ShapeName::kStep);
  // Views 2 and 3 agree on a sheet before the surface; the others see the surface.
  for (const size_t v : {2, 3}) {
    const View& view = input.scene().views[v];
    DepthMap& map = input.maps[v];
    const Eigen::Vector3d normal = view.cam_from_world.rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d on_sheet = view.cam_from_world * Eigen::Vector3d(0, 0, 0.9);
    for (int row = 0; row < map.depth.height; ++row) {
      for (int column = 0; column < map.depth.width; ++column) {
        map.depth(column, row) = static_cast<float>(normal.dot(on_sheet) /
                                                    normal.dot(view.camera.PixelRay(column, row)));
        map.normal(column, row) = normal.cast<float>();
      }
    }
  }
  const VisibilityCloud cloud = input.Fuse({});
  for (const Eigen::Vector3f& x : cloud.positions) ASSERT_LT(x.z(), 0.85f);
}

// Two views from one place see the same, and say no more than one of them.
TEST(FuseDepthMaps, ViewsFromOnePlaceDoNotConfirmEachOther) {
  TrueMaps input(ShapeName::kRelief);
  FusionOptions options;
  options.weak_max_reproj_error = 0;
  ASSERT_GT(input.Fuse(options).size(), 5000u);
  // All photos come from two places only.
  for (size_t v = 0; v < input.maps.size(); ++v) {
    input.synthetic.scene.views[v].cam_from_world =
        input.synthetic.scene.views[v % 2 == 0 ? 2 : 3].cam_from_world;
    input.maps[v] =
        TrueDepthMap(*input.synthetic.shape, input.synthetic.scene.views[v], RunContext(1));
    input.neighbors[v].clear();
    for (int other = 0; other < 6; ++other) {
      if (other != static_cast<int>(v)) input.neighbors[v].push_back({other, 1.0, 10, 10});
    }
  }
  EXPECT_EQ(input.Fuse(options).size(), 0u);
  options.min_num_pixels = 2;
  EXPECT_GT(input.Fuse(options).size(), 3000u);
}

TEST(FuseDepthMaps, DropsScatteredPairs) {
  TrueMaps input(ShapeName::kStep);
  KeepOnePair(&input);
  Raster<float>& depth = input.maps[2].depth;
  for (int row = 0; row < depth.height; ++row) {
    for (int column = 0; column < depth.width; ++column) {
      if (column % 20 > 8 || row % 20 > 8) depth(column, row) = 0;
    }
  }
  const VisibilityCloud cloud = input.Fuse({});
  EXPECT_EQ(cloud.size(), 0u);
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

void ExpectSame(const VisibilityCloud& a, const VisibilityCloud& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.view_begin, b.view_begin);
  EXPECT_EQ(a.view_idxs, b.view_idxs);
}

TEST(FuseViews, GivesTheSameForAnyDivision) {
  TrueMaps input(ShapeName::kSphereOnGround);
  input.AddNoise(0.5);
  const VisibilityCloud whole = input.Fuse({});
  const std::vector<std::vector<std::vector<int>>> divisions = {
      {{0}, {1}, {2}, {3}, {4}, {5}}, {{0, 1, 2, 3}, {4, 5}}, {{}, {0}, {1, 2, 3, 4, 5}}};
  for (const auto& division : divisions) {
    VisibilityCloud joined;
    for (const std::vector<int>& group : division) joined.Append(input.FuseOf(group));
    ExpectSame(joined, whole);
  }
}

TEST(FuseViews, ReadsTheNeighborsOnly) {
  TrueMaps input(ShapeName::kRelief);
  const std::vector<int> read = FusionNeighbors(input.scene(), input.neighbors, {})[0];
  ASSERT_LT(read.size(), 5u);
  const VisibilityCloud before = input.FuseOf({0});
  ASSERT_GT(before.size(), 100u);
  for (int v = 1; v < input.scene().num_views(); ++v) {
    if (std::find(read.begin(), read.end(), v) != read.end()) continue;
    DepthMap& map = input.maps[static_cast<size_t>(v)];
    map.depth.pixels.assign(map.depth.size(), 0.0f);
  }
  ExpectSame(input.FuseOf({0}), before);
}

TEST(FusionNeighbors, AreThoseThatAViewChoseAndThoseThatChoseIt) {
  const TrueMaps input(ShapeName::kRelief);
  const Neighbor to_first{0, 2.0, 10, 10}, to_second{1, 1.0, 10, 10};
  const std::vector<std::vector<Neighbor>> neighbors = {{}, {}, {to_first, to_second}, {}, {}, {}};
  using Lists = std::vector<std::vector<int>>;
  FusionOptions options;
  EXPECT_EQ(FusionNeighbors(input.scene(), neighbors, options),
            (Lists{{2}, {2}, {0, 1}, {}, {}, {}}));
  options.check_num_images = 1;
  EXPECT_EQ(FusionNeighbors(input.scene(), neighbors, options), (Lists{{2}, {2}, {0}, {}, {}, {}}));
}

// Views whose map has nearly the depth of `x` where it lies.
int CountWitnesses(const TrueMaps& input, const Eigen::Vector3d& x) {
  int count = 0;
  for (size_t v = 0; v < input.maps.size(); ++v) {
    const View& view = input.scene().views[v];
    const Raster<float>& depth = input.maps[v].depth;
    const PinholeCamera camera = view.camera.Resized(depth.width, depth.height);
    const Eigen::Vector3d in_cam = view.cam_from_world * x;
    const Eigen::Vector2d x_px = camera.Project(in_cam);
    if (!(in_cam.z() > 0) || !camera.Contains(x_px)) continue;
    const double seen = depth(static_cast<int>(x_px.x()), static_cast<int>(x_px.y()));
    count += std::abs(seen - in_cam.z()) < 0.005 * in_cam.z();
  }
  return count;
}

double DistanceTo(const VisibilityCloud& cloud, const Eigen::Vector3d& x) {
  double squared = std::numeric_limits<double>::max();
  for (const Eigen::Vector3f& position : cloud.positions) {
    squared = std::min(squared, (position.cast<double>() - x).squaredNorm());
  }
  return std::sqrt(squared);
}

// Pixels that leave their point to another view leave no hole: what three views see has a point
// within two pixels.
void ExpectNoHoles(const TrueMaps& input, const VisibilityCloud& cloud) {
  size_t num_checked = 0;
  for (size_t v = 0; v < input.maps.size(); ++v) {
    const View& view = input.scene().views[v];
    const Raster<float>& depth = input.maps[v].depth;
    const PinholeCamera camera = view.camera.Resized(depth.width, depth.height);
    for (size_t i = 0; i < depth.size(); i += 37) {
      if (!(depth.pixels[i] > 0)) continue;
      const int column = static_cast<int>(i) % depth.width, row = static_cast<int>(i) / depth.width;
      const Eigen::Vector3d x =
          view.cam_from_world.Inverse() * (depth.pixels[i] * camera.PixelRay(column, row));
      if (CountWitnesses(input, x) < 3) continue;
      ++num_checked;
      EXPECT_LT(DistanceTo(cloud, x), 2 * depth.pixels[i] / camera.MeanFocalLength()) << v;
    }
  }
  EXPECT_GT(num_checked, 100u);
}

TEST(FuseDepthMaps, LeavesNoHoles) {
  for (const ShapeName shape : {ShapeName::kRelief, ShapeName::kStep, ShapeName::kSphereOnGround}) {
    TrueMaps input(shape);
    input.MakeAllNeighbors();
    ExpectNoHoles(input, input.Fuse({}));
  }
}

TEST(FuseDepthMaps, LeavesNoHolesWhereDepthsAreNoisy) {
  TrueMaps input(ShapeName::kSphereOnGround);
  input.MakeAllNeighbors();
  input.AddNoise(1.0);
  const VisibilityCloud cloud = input.Fuse({});
  ExpectNoHoles(TrueMaps(ShapeName::kSphereOnGround), cloud);
}

// Whichever of the views come first.
TEST(FuseDepthMaps, KeepsThePixelsOfFinerViews) {
  for (const std::vector<size_t>& coarse : {std::vector<size_t>{0, 1, 2}, {3, 4, 5}}) {
    TrueMaps input(ShapeName::kRelief);
    input.MakeAllNeighbors();
    input.Halve(coarse);
    ExpectNoHoles(input, input.Fuse({}));
  }
}

TEST(FuseDepthMaps, DoesNotDependOnThreads) {
  TrueMaps input(ShapeName::kRelief);
  input.AddNoise(0.5);
  const VisibilityCloud one = input.Fuse({}, 1), two = input.Fuse({}, 2);
  ExpectSame(one, two);
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
  expect_refused(&FusionOptions::weak_max_reproj_error, -1.0, "weak_max_reproj_error");
  expect_refused(&FusionOptions::check_num_images, 0, "check_num_images");
}

}  // namespace
}  // namespace lsmvs
