#include "lsmvs/surface/weights/free_space_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Sampling {
  ShapeName shape;
  double outlier_fraction = 0.3;
  double max_proj_dist = 1;
  int num_levels = 1;
};

// The merged cloud of a scene, before and after.
struct Filtered {
  SyntheticScene scene;
  MergedCloud before, after;

  explicit Filtered(const Sampling& sampling, const RunContext& context = RunContext(1))
      : scene(MakeScene(sampling.shape, 16, 320, 240)) {
    SampledCloudOptions cloud_options;
    cloud_options.num_points = 30000;
    cloud_options.noise = 0.5 * scene.gsd;
    cloud_options.outlier_fraction = sampling.outlier_fraction;
    const VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, cloud_options, context);
    FreeSpaceFilterOptions options;
    options.num_levels = sampling.num_levels;
    options.merging = {sampling.max_proj_dist, 0.01, 3.0, true};
    options.weights = {0.8, 0.5, 0.7};
    options.cells_at_once = kAllNodes;
    before = after = MergePoints(scene.scene, cloud, options.merging, context);
    const size_t num_dropped = FilterFreeSpace(scene.scene, options, context, &after);
    EXPECT_EQ(num_dropped, before.positions.size() - after.positions.size());
    EXPECT_EQ(num_dropped, after.num_filtered_vertices);
  }

  // Vertices whose distance before the surface, in pixels, is in a range; negative: behind.
  static size_t CountBetween(const Filtered& filtered, const MergedCloud& cloud, double low,
                             double high) {
    return static_cast<size_t>(
        std::count_if(cloud.positions.begin(), cloud.positions.end(), [&](const auto& position) {
          const Eigen::Vector3d x = cloud.frame.ToWorld(position.template cast<double>());
          const SurfacePoint closest = filtered.scene.shape->Closest(x);
          const double distance = (x - closest.position).dot(closest.normal) / filtered.scene.gsd;
          return distance >= low && distance < high;
        }));
  }
  size_t CountBefore(double low, double high) const {
    return CountBetween(*this, before, low, high);
  }
  size_t CountAfter(double low, double high) const { return CountBetween(*this, after, low, high); }
};

TEST(FreeSpaceFilter, DropsNothingOfCleanClouds) {
  for (const ShapeName shape : {ShapeName::kThinWalls, ShapeName::kPole, ShapeName::kTerrain}) {
    const Filtered clean({shape, 0, 2.2, 2});
    EXPECT_EQ(clean.after.positions.size(), clean.before.positions.size())
        << static_cast<int>(shape);
  }
}

// Two walls 3 pixels thick and 5 apart, and a pole of 6 pixels, among outliers, with vertices 1 to
// 4 pixels apart: coarse ones are up to 16 apart. Many outliers are behind the surface, where no
// view contradicts them.
TEST(FreeSpaceFilter, DropsFarOutliersAndKeepsThinParts) {
  for (const Sampling& sampling :
       {Sampling{ShapeName::kSphere, 0.3, 2.2}, Sampling{ShapeName::kThinWalls, 0.3, 1.0},
        Sampling{ShapeName::kThinWalls, 0.3, 2.2}, Sampling{ShapeName::kPole, 0.3, 2.2},
        Sampling{ShapeName::kPole, 0.3, 4.0}}) {
    const Filtered filtered(sampling);
    EXPECT_EQ(filtered.CountAfter(-2.5, 2.5), filtered.CountBefore(-2.5, 2.5));
    const double far = 12 * sampling.max_proj_dist;
    EXPECT_LT(4 * filtered.CountAfter(far, kInfinity), 3 * filtered.CountBefore(far, kInfinity));
  }
}

TEST(FreeSpaceFilter, WhatStaysKeepsItsBytesForAnyNumberOfThreads) {
  const Sampling sampling{ShapeName::kSphere, 0.3, 2.2, 2};
  const Filtered one(sampling), two(sampling, RunContext(2));
  EXPECT_EQ(one.after.positions, two.after.positions);
  EXPECT_EQ(one.after.vertex_of_point, two.after.vertex_of_point);
  const MergedCloud &before = one.before, &after = one.after;
  ASSERT_LT(after.positions.size(), before.positions.size());
  // By vertex before: the one that it is after; its points have gone along.
  std::vector<uint32_t> kept(before.positions.size(), MergedCloud::kIgnoredPoint);
  std::vector<uint8_t> has_points(before.positions.size(), 0);
  ASSERT_EQ(after.vertex_of_point.size(), before.vertex_of_point.size());
  for (size_t p = 0; p < before.vertex_of_point.size(); ++p) {
    const uint32_t v = before.vertex_of_point[p], w = after.vertex_of_point[p];
    if (v == MergedCloud::kIgnoredPoint) {
      ASSERT_EQ(w, MergedCloud::kIgnoredPoint);
      continue;
    }
    ASSERT_TRUE(!has_points[v] || kept[v] == w);
    has_points[v] = 1;
    kept[v] = w;
  }
  // In the order of before, each with all that it had.
  size_t v = 0;
  for (size_t w = 0; w < after.positions.size(); ++w, ++v) {
    while (kept.at(v) == MergedCloud::kIgnoredPoint) ++v;
    ASSERT_EQ(kept[v], w);
    ASSERT_EQ(after.positions[w], before.positions[v]);
    ASSERT_EQ(after.normals[w], before.normals[v]);
    ASSERT_EQ(after.colors[w], before.colors[v]);
    ASSERT_EQ(after.SightsOf(w).size(), before.SightsOf(v).size());
    for (size_t s = 0; s < after.SightsOf(w).size(); ++s) {
      ASSERT_EQ(after.SightsOf(w)[s].view_idx, before.SightsOf(v)[s].view_idx);
      ASSERT_EQ(after.SightsOf(w)[s].support, before.SightsOf(v)[s].support);
    }
  }
}

// No tetrahedra, and no level.
TEST(FreeSpaceFilter, DropsNothingWithoutASurface) {
  const SyntheticScene scene = MakeScene(ShapeName::kSphere, 4, 320, 240);
  SampledCloudOptions sampling;
  sampling.num_points = 300;
  const VisibilityCloud all = SampleCloud(*scene.shape, scene.scene, sampling, RunContext(1));
  VisibilityCloud few;
  for (size_t p = 0; p < 3; ++p) {
    few.Add(all.positions[p], all.normals[p], all.colors[p], all.ViewsOf(p));
  }
  for (const double max_proj_dist : {0.0, 1.0}) {
    for (const VisibilityCloud* cloud : std::array<const VisibilityCloud*, 2>{&few, &all}) {
      FreeSpaceFilterOptions options;
      options.num_levels = cloud == &few || max_proj_dist == 0 ? 4 : 0;
      options.merging = {max_proj_dist, 0.01, 3.0, true};
      options.weights = {0.8, 0.5, 0.7};
      options.cells_at_once = kAllNodes;
      MergedCloud merged = MergePoints(scene.scene, *cloud, options.merging, RunContext(1));
      EXPECT_EQ(FilterFreeSpace(scene.scene, options, RunContext(1), &merged), 0u);
    }
  }
}

}  // namespace
}  // namespace lsmvs
