#include "lsmvs/stereo/patch_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <vector>

#include "lsmvs/synthetic/box_union.h"
#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/truth.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

SyntheticScene SceneOf(ShapeName shape, double weak_fraction) {
  SyntheticSceneOptions options;
  options.shape = shape;
  options.num_views = 6;
  options.width = 200;
  options.height = 150;
  SyntheticScene scene = MakeScene(options, RunContext(1));
  scene.photo.texture.weak_fraction = weak_fraction;
  return scene;
}

// A wall 8 wide and 4 high at y = 0 with ground before it, as people 1.6 high see it who stand two
// steps apart. Sparse points are on the wall alone.
SyntheticScene GroundBeforeAWall() {
  SyntheticScene result;
  result.shape = std::make_shared<BoxUnion>(
      std::vector<Eigen::AlignedBox3d>{{Eigen::Vector3d(-9, -9, -0.5), Eigen::Vector3d(9, 1, 0)},
                                       {Eigen::Vector3d(-4, 0, -0.5), Eigen::Vector3d(4, 1, 4)}});
  const PinholeCamera camera = MakeCamera(240, 180, 0.9);
  for (int v = 0; v < 6; ++v) {
    const double x = -4.0 + 1.6 * v;
    result.scene.views.push_back(
        MakeView(v, camera, LookAt({x, -7.0 + 0.1 * (v % 2), 1.6}, {0.4 * x, 0, 1.2})));
  }
  result.scene.points =
      SampleSparsePoints(*result.shape, result.scene, 1500, 0.0, 5, RunContext(1));
  std::erase_if(result.scene.points, [](const SparsePoint& p) { return p.x_in_world.z() < 0.2; });
  result.gsd = GroundSamplingDistance(result.scene);
  result.photo.texture.finest_wavelength = 2.5 * result.gsd;
  result.photo.texture.coarsest_wavelength = 80.0 * result.gsd;
  return result;
}

// A rendered scene with its photos on disk and all that the matcher takes.
struct Rendered {
  explicit Rendered(ShapeName shape, double weak_fraction = 0)
      : Rendered(SceneOf(shape, weak_fraction)) {}
  explicit Rendered(SyntheticScene scene_to_render) : synthetic(std::move(scene_to_render)) {
    synthetic.photo.noise_sigma = 1.0;
    synthetic.photo.gain_sigma = 0.05;
    WritePhotos(*synthetic.shape, synthetic.photo, folder.path().string(), &synthetic.scene,
                RunContext(1));
    Open();
    neighbors = SelectNeighbors(scene(), {}, RunContext(2));
    ranges = EstimateDepthRanges(scene());
  }
  void Open() { images = MakeImageStore(scene(), {}); }
  const Scene& scene() const { return synthetic.scene; }

  DepthMap Photometric(int view_idx, const PatchMatchOptions& options, int threads = 1) const {
    const size_t v = static_cast<size_t>(view_idx);
    return EstimateDepthMap(scene(), *images, view_idx, neighbors[v], ranges[v], nullptr, options,
                            RunContext(threads));
  }
  MemoryDepthMaps AllPhotometric(const PatchMatchOptions& options) const {
    std::vector<DepthMap> maps;
    for (int v = 0; v < scene().num_views(); ++v) maps.push_back(Photometric(v, options));
    return MemoryDepthMaps(std::move(maps));
  }
  DepthMap Geometric(int view_idx, const DepthMapSource& maps, const PatchMatchOptions& options,
                     int threads = 1) const {
    const size_t v = static_cast<size_t>(view_idx);
    return EstimateDepthMap(scene(), *images, view_idx, neighbors[v], ranges[v], &maps, options,
                            RunContext(threads));
  }

  TemporaryFolder folder;
  SyntheticScene synthetic;
  std::unique_ptr<ImageStore> images;
  std::vector<std::vector<Neighbor>> neighbors;
  std::vector<DepthRange> ranges;
};

// Errors of depth in pixels on the surface (depth / focal length).
struct DepthErrors {
  double completeness = 0;            // share of the visible surface with a depth
  double within_1 = 0, within_3 = 0;  // shares of the depths
  double bias = 0;                    // mean of the signed errors below 3
};

DepthErrors Compare(const Rendered& rendered, int view_idx, const DepthMap& map) {
  const View& view = rendered.scene().views[static_cast<size_t>(view_idx)];
  const DepthMap truth = TrueDepthMap(*rendered.synthetic.shape, view, map.depth.width,
                                      map.depth.height, RunContext(1));
  int visible = 0, known = 0, within_1 = 0, within_3 = 0;
  double sum = 0;
  for (size_t i = 0; i < map.depth.size(); ++i) {
    const double expected = truth.depth.pixels[i], depth = map.depth.pixels[i];
    if (!(expected > 0)) continue;
    ++visible;
    if (!(depth > 0)) continue;
    ++known;
    const double error = (depth - expected) / expected * view.camera.MeanFocalLength();
    within_1 += std::abs(error) < 1;
    within_3 += std::abs(error) < 3;
    if (std::abs(error) < 3) sum += error;
  }
  return {double(known) / visible, double(within_1) / known, double(within_3) / known,
          sum / std::max(1, within_3)};
}

TEST(EstimateDepthMap, FindsPlanesWithoutBias) {
  const Rendered rendered(ShapeName::kStep);
  const PatchMatchOptions options;
  const auto maps = rendered.AllPhotometric(options);
  EXPECT_EQ(maps.Get(2)->depth.width, 100);
  const DepthMap map = rendered.Geometric(2, maps, options);
  EXPECT_EQ(map.depth.width, 200);
  const DepthErrors errors = Compare(rendered, 2, map);
  EXPECT_GT(errors.completeness, 0.75);
  EXPECT_GT(errors.within_1, 0.87);
  EXPECT_LT(std::abs(errors.bias), 0.1);
}

TEST(EstimateDepthMap, FindsARelief) {
  const Rendered rendered(ShapeName::kRelief);
  const PatchMatchOptions options;
  const auto maps = rendered.AllPhotometric(options);
  const DepthErrors errors = Compare(rendered, 2, rendered.Geometric(2, maps, options));
  EXPECT_GT(errors.completeness, 0.94);
  EXPECT_GT(errors.within_3, 0.77);
}

// The slope of ground in the photos is steep, and no sparse point tells it.
TEST(EstimateDepthMap, FindsGroundWithoutSparsePoints) {
  const Rendered rendered(GroundBeforeAWall());
  const PatchMatchOptions options;
  const auto maps = rendered.AllPhotometric(options);
  int ground = 0, right = 0;
  for (int v = 1; v < 5; ++v) {
    const View& view = rendered.scene().views[static_cast<size_t>(v)];
    const DepthMap map = rendered.Geometric(v, maps, options);
    const DepthMap truth = TrueDepthMap(*rendered.synthetic.shape, view, RunContext(1));
    for (size_t i = 0; i < map.depth.size(); ++i) {
      const Eigen::Vector3d up = view.cam_from_world.rotation * Eigen::Vector3d::UnitZ();
      if (truth.normal.pixels[i].cast<double>().dot(up) < 0.9) continue;
      ++ground;
      right += std::abs(map.depth.pixels[i] / truth.depth.pixels[i] - 1) < 0.01;
    }
  }
  ASSERT_GT(ground, 20000);
  EXPECT_GT(right, 0.8 * ground) << double(right) / ground;
}

// With one neighbour, what lies outside the sparse points' range of depth, and what the neighbour
// sees, is found all the same.
TEST(EstimateDepthMap, MatchesWithOneNeighborBeyondTheSparsePoints) {
  Rendered rendered(ShapeName::kStep);
  for (int v : {2, 3}) {
    rendered.neighbors[static_cast<size_t>(v)] = {{.view_idx = 5 - v, .score = 1}};
    DepthRange& range = rendered.ranges[static_cast<size_t>(v)];
    range.max = std::sqrt(range.min * range.max);
  }
  const PatchMatchOptions options;
  std::vector<DepthMap> maps(6);
  for (int v : {2, 3}) maps[static_cast<size_t>(v)] = rendered.Photometric(v, options);
  const DepthErrors errors =
      Compare(rendered, 2, rendered.Geometric(2, MemoryDepthMaps(maps), options));
  EXPECT_GT(errors.completeness, 0.25);
  EXPECT_GT(errors.within_3, 0.7);
}

TEST(EstimateDepthMap, GivesUnitNormalsTowardsTheCamera) {
  const Rendered rendered(ShapeName::kStep);
  PatchMatchOptions options;
  options.geom_consistency = false;
  const DepthMap map = rendered.Photometric(2, options);
  ASSERT_EQ(map.depth.width, 200);
  const PinholeCamera& camera = rendered.scene().views[2].camera;
  for (int row = 0; row < map.depth.height; ++row) {
    for (int column = 0; column < map.depth.width; ++column) {
      const Eigen::Vector3d normal = map.normal(column, row).cast<double>();
      if (map.depth(column, row) > 0) {
        EXPECT_NEAR(normal.norm(), 1.0, 1e-5);
        EXPECT_LT(normal.dot(camera.PixelRay(column, row)), 0);
      } else {
        EXPECT_EQ(normal.norm(), 0.0);
      }
    }
  }
}

TEST(EstimateDepthMap, CompletesWeakTextureFromCoarserLevels) {
  const Rendered rendered(ShapeName::kRelief, 0.4);
  const PatchMatchOptions options;
  const auto maps = rendered.AllPhotometric(options);
  const DepthErrors errors = Compare(rendered, 2, rendered.Geometric(2, maps, options));
  EXPECT_GT(errors.completeness, 0.9);
  EXPECT_GT(errors.within_3, 0.7);
}

TEST(EstimateDepthMap, DoesNotDependOnThreads) {
  const Rendered rendered(ShapeName::kStep);
  const PatchMatchOptions options;
  const auto maps = rendered.AllPhotometric(options);
  EXPECT_EQ(maps.Get(1)->depth.pixels, rendered.Photometric(1, options, 2).depth.pixels);
  const DepthMap one = rendered.Geometric(1, maps, options, 1);
  const DepthMap two = rendered.Geometric(1, maps, options, 2);
  EXPECT_EQ(one.depth.pixels, two.depth.pixels);
  EXPECT_EQ(one.normal.pixels, two.normal.pixels);
}

TEST(EstimateDepthMap, KeepsToTheDepthRangeAndTheMask) {
  Rendered rendered(ShapeName::kStep);
  cv::Mat mask(150, 200, CV_8U, cv::Scalar(255));
  mask.colRange(0, 60) = 0;
  cv::imwrite((rendered.folder.path() / "0001.png.png").string(), mask);
  rendered.synthetic.scene.mask_folder = rendered.folder.path().string();
  rendered.Open();
  PatchMatchOptions options;
  options.geom_consistency = false;
  options.depth_min = rendered.ranges[1].min * 1.2;
  options.depth_max = rendered.ranges[1].max * 0.9;
  const DepthMap map = rendered.Photometric(1, options);
  int num_known = 0;
  for (int row = 0; row < 150; ++row) {
    for (int column = 0; column < 200; ++column) {
      const float depth = map.depth(column, row);
      if (depth == 0) continue;
      ++num_known;
      EXPECT_GE(column, 60);
      EXPECT_GE(depth, *options.depth_min * 0.9999);
      EXPECT_LE(depth, *options.depth_max * 1.0001);
    }
  }
  EXPECT_GT(num_known, 1000);
}

TEST(EstimateDepthMap, IsEmptyWithoutNeighborsOrRange) {
  const Rendered rendered(ShapeName::kStep);
  const auto is_empty = [](const DepthMap& map) {
    return std::all_of(map.depth.pixels.begin(), map.depth.pixels.end(),
                       [](float depth) { return depth == 0; });
  };
  EXPECT_TRUE(is_empty(EstimateDepthMap(rendered.scene(), *rendered.images, 0, {},
                                        rendered.ranges[0], nullptr, {}, RunContext(1))));
  EXPECT_TRUE(is_empty(EstimateDepthMap(rendered.scene(), *rendered.images, 0,
                                        rendered.neighbors[0], {}, nullptr, {}, RunContext(1))));
}

TEST(PatchMatchOptions, HaveValidDefaultsAndNameWhatIsOutOfBounds) {
  PatchMatchOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  const auto expect_refused = [](auto PatchMatchOptions::*field, auto value, const char* name) {
    PatchMatchOptions bad;
    bad.*field = value;
    std::string message;
    EXPECT_FALSE(bad.Check(&message)) << name;
    EXPECT_NE(message.find(name), std::string::npos) << message;
  };
  expect_refused(&PatchMatchOptions::window_radius, 0, "window_radius");
  expect_refused(&PatchMatchOptions::window_step, 0, "window_step");
  expect_refused(&PatchMatchOptions::num_iterations, 0, "num_iterations");
  expect_refused(&PatchMatchOptions::max_num_neighbors, 17, "max_num_neighbors");
  expect_refused(&PatchMatchOptions::max_num_fine_neighbors, 0, "max_num_fine_neighbors");
  expect_refused(&PatchMatchOptions::sigma_spatial, 0.0, "sigma_spatial");
  expect_refused(&PatchMatchOptions::sigma_color, 0.0, "sigma_color");
  expect_refused(&PatchMatchOptions::noise_sigma, 0.0, "noise_sigma");
  expect_refused(&PatchMatchOptions::geom_consistency_regularizer, -1.0, "regularizer");
  expect_refused(&PatchMatchOptions::geom_consistency_max_cost, -1.0, "geom_consistency_max_cost");
  expect_refused(&PatchMatchOptions::filter_min_ncc, 2.0, "filter_min_ncc");
  expect_refused(&PatchMatchOptions::filter_min_triangulation_angle, -1.0, "angle");
  expect_refused(&PatchMatchOptions::filter_min_num_consistent, -1, "num_consistent");
  expect_refused(&PatchMatchOptions::filter_geom_consistency_max_cost, -1.0, "filter_geom");
  expect_refused(&PatchMatchOptions::depth_min, 0.0, "depth_min");
  expect_refused(&PatchMatchOptions::depth_max, -1.0, "depth_max");
}

}  // namespace
}  // namespace lsmvs
