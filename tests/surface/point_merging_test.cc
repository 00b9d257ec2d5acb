#include "lsmvs/surface/point_merging.h"

#include <gtest/gtest.h>

#include <vector>

#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/shuffled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

const RunContext kContext(1);
const PointMergingOptions kOptions{
    .max_proj_dist = 2.2, .max_depth_dist = 0.01, .visibility_sigma = 3, .keep_assignment = true};

void ExpectSameBytes(const MergedCloud& a, const MergedCloud& b) {
  EXPECT_EQ(a.frame.origin, b.frame.origin);
  EXPECT_EQ(a.frame.world_per_unit, b.frame.world_per_unit);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.sight_begin, b.sight_begin);
  EXPECT_EQ(a.num_ignored_points, b.num_ignored_points);
  ASSERT_EQ(a.sights.size(), b.sights.size());
  for (size_t i = 0; i < a.sights.size(); ++i) {
    ASSERT_EQ(a.sights[i].view_idx, b.sights[i].view_idx);
    ASSERT_EQ(a.sights[i].support, b.sights[i].support);
  }
}

void ExpectAFunctionOfThePoints(const Scene& scene, const VisibilityCloud& cloud) {
  const MergedCloud merged = MergePoints(scene, cloud, kOptions, kContext);
  EXPECT_LT(merged.positions.size(), cloud.size());
  EXPECT_GT(merged.positions.size(), cloud.size() / 100);
  for (const uint64_t seed : {1, 2, 3}) {
    const ShuffledCloud shuffled = Shuffle(cloud, seed);
    const MergedCloud again = MergePoints(scene, shuffled.cloud, kOptions, RunContext(2));
    ExpectSameBytes(merged, again);
    for (size_t p = 0; p < cloud.size(); ++p) {
      ASSERT_EQ(again.vertex_of_point[p], merged.vertex_of_point[shuffled.origin[p]]);
    }
  }
}

VisibilityCloud NoisyCloud(const SyntheticScene& scene, size_t num_points) {
  SampledCloudOptions sampling;
  sampling.num_points = num_points;
  sampling.noise = scene.gsd;
  sampling.outlier_fraction = 0.3;
  return SampleCloud(*scene.shape, scene.scene, sampling, kContext);
}

TEST(PointMerging, DoesNotDependOnTheOrderOfThePoints) {
  for (const ShapeName shape : {ShapeName::kSphere, ShapeName::kThinWalls, ShapeName::kTerrain}) {
    const SyntheticScene scene = MakeScene(shape, 12, 320, 240);
    ExpectAFunctionOfThePoints(scene.scene, NoisyCloud(scene, 20000));
  }
}

// Points of one position that differ in normal, colour or views; equal points; and such that no
// view sees or that are not finite.
TEST(PointMerging, DoesNotDependOnTheOrderOfPointsInOnePlace) {
  const SyntheticScene scene = MakeScene(ShapeName::kSphere, 12, 320, 240);
  const VisibilityCloud once = NoisyCloud(scene, 2000);
  VisibilityCloud cloud = once;
  for (uint32_t p = 0; p < once.size(); ++p) {
    const auto views = once.ViewsOf(p);
    const std::vector<uint32_t> one_view(1, views.back());
    cloud.Add(once.positions[p], once.normals[p], once.colors[p], views);
    cloud.Add(once.positions[p], -once.normals[p], once.colors[p], views);
    cloud.Add(once.positions[p], once.normals[p], Color(1, 2, static_cast<uint8_t>(p)), views);
    cloud.Add(once.positions[p], once.normals[p], once.colors[p], one_view);
    cloud.Add(once.positions[p], once.normals[p], once.colors[p], {});
  }
  cloud.Add(Eigen::Vector3f::Constant(NAN), Eigen::Vector3f::Zero(), Color::Zero(),
            std::vector<uint32_t>{0});
  ExpectAFunctionOfThePoints(scene.scene, cloud);
}

// The frame of large clouds comes from a sample.
TEST(PointMerging, FrameOfLargeCloudsDoesNotDependOnTheOrder) {
  const SyntheticScene scene = MakeScene(ShapeName::kSphere, 2, 320, 240);
  const VisibilityCloud few = NoisyCloud(scene, 3000);
  VisibilityCloud cloud;
  for (int i = 0; i < 40; ++i) {
    for (size_t p = 0; p < few.size(); ++p) {
      cloud.Add(few.positions[p] * (1 + 1e-5f * static_cast<float>(i)), few.normals[p],
                few.colors[p], few.ViewsOf(p));
    }
  }
  ASSERT_GT(cloud.size(), 110000u);
  ExpectAFunctionOfThePoints(scene.scene, cloud);
  // All points of a cloud in one place: none or all are in the sample.
  VisibilityCloud same;
  for (int i = 0; i < 110000; ++i) {
    same.Add(few.positions[0], few.normals[0], few.colors[0], few.ViewsOf(0));
  }
  const MergedCloud merged = MergePoints(scene.scene, same, kOptions, kContext);
  ASSERT_EQ(merged.positions.size(), 1u);
  EXPECT_EQ(merged.frame.origin, few.positions[0].cast<double>());
}

}  // namespace
}  // namespace lsmvs
