#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lsmvs/scene/view_selection.h"
#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/truth.h"

namespace lsmvs {
namespace {

constexpr ShapeName kAllNames[] = {
    ShapeName::kSphere,         ShapeName::kBox,       ShapeName::kTorus,
    ShapeName::kStep,           ShapeName::kThinWalls, ShapeName::kPole,
    ShapeName::kSphereOnGround, ShapeName::kTerrain,   ShapeName::kRelief};

TEST(Random, IsUniformGaussianAndReproducible) {
  Random random(5);
  double sum = 0, squares = 0, uniform = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.Gaussian();
    sum += x;
    squares += x * x;
    const double u = random.Uniform();
    EXPECT_GE(u, 0.0);
    EXPECT_LT(u, 1.0);
    uniform += u;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.03);
  EXPECT_NEAR(squares / kCount, 1.0, 0.05);
  EXPECT_NEAR(uniform / kCount, 0.5, 0.01);
  EXPECT_EQ(Random(5, 1).Bits(), Random(5, 1).Bits());
  EXPECT_NE(Random(5, 1).Bits(), Random(5, 2).Bits());
  EXPECT_NE(Random(5, 1).Bits(), Random(6, 1).Bits());
}

TEST(Cameras, LookAtPutsTheTargetInTheMiddleAndUpUp) {
  const PinholeCamera camera = MakeCamera(640, 480);
  for (const Eigen::Vector3d& center :
       {Eigen::Vector3d(3, 1, 2), Eigen::Vector3d(-1, 4, -2), Eigen::Vector3d(0.5, 0.2, 5)}) {
    const Eigen::Vector3d target(0.5, 0.2, 0.1);
    const Rigid3 pose = LookAt(center, target);
    EXPECT_NEAR((pose.rotation * pose.rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 0,
                1e-12);
    EXPECT_NEAR(pose.rotation.determinant(), 1.0, 1e-12);
    EXPECT_NEAR((pose.OriginInSource() - center).norm(), 0, 1e-12);
    EXPECT_NEAR((camera.Project(pose * target) - Eigen::Vector2d(320, 240)).norm(), 0, 1e-9);
    if (std::abs(center.z()) < 4) {
      EXPECT_LT(camera.Project(pose * (target + Eigen::Vector3d(0, 0, 0.1))).y(), 240);
    }
  }
}

TEST(Cameras, RingsAndGrids) {
  const auto ring = RingCenters({1, 2, 3}, 2.0, 0.5, 8);
  ASSERT_EQ(ring.size(), 8u);
  for (const Eigen::Vector3d& c : ring) {
    EXPECT_NEAR((c - Eigen::Vector3d(1, 2, 3.5)).norm(), 2.0, 1e-12);
  }
  EXPECT_NEAR((ring[0] - ring[7]).norm(), (ring[0] - ring[1]).norm(), 1e-12);
  const auto arc = RingCenters({0, 0, 0}, 1.0, 0, 3, 0, 90);
  EXPECT_NEAR((arc[2] - Eigen::Vector3d(0, 1, 0)).norm(), 0, 1e-12);
  const auto grid = GridCenters(2, 1, 5, 3, 2);
  ASSERT_EQ(grid.size(), 6u);
  EXPECT_EQ(grid[2], Eigen::Vector3d(2, -1, 5));
  EXPECT_EQ(grid[3], Eigen::Vector3d(2, 1, 5));
}

TEST(Truth, DepthMapsReprojectIntoOtherViewsWithoutBias) {
  const SyntheticScene s = MakeScene(ShapeName::kSphereOnGround, 6, 96, 72);
  const View& view = s.scene.views[0];
  const DepthMap map = TrueDepthMap(*s.shape, view, RunContext());
  int num_hits = 0;
  for (int row = 0; row < map.depth.height; ++row) {
    for (int column = 0; column < map.depth.width; ++column) {
      const float depth = map.depth(column, row);
      if (depth == 0) continue;
      ++num_hits;
      const Eigen::Vector3d x =
          view.cam_from_world.Inverse() * (depth * view.camera.PixelRay(column, row));
      EXPECT_NEAR(s.shape->SignedDistance(x), 0, 1e-5);
      const Eigen::Vector3f normal = map.normal(column, row);
      EXPECT_NEAR(normal.norm(), 1.0, 1e-5);
      EXPECT_LT(normal.dot(view.camera.PixelRay(column, row).cast<float>()), 1e-4);
    }
  }
  EXPECT_GT(num_hits, 3000);
}

TEST(Truth, ReducedDepthMapCoversTheSameField) {
  const SyntheticScene s = MakeScene(ShapeName::kSphere, 4, 120, 80);
  const DepthMap full = TrueDepthMap(*s.shape, s.scene.views[1], RunContext());
  const DepthMap half = TrueDepthMap(*s.shape, s.scene.views[1], 60, 40, RunContext());
  EXPECT_EQ(half.depth.width, 60);
  const float middle =
      0.25f * (full.depth(59, 39) + full.depth(60, 39) + full.depth(59, 40) + full.depth(60, 40));
  EXPECT_NEAR(half.depth(30, 20), middle, 0.01);
}

TEST(Truth, SeesOnlyWhatIsNotHidden) {
  const SyntheticScene s = MakeScene(ShapeName::kSphere, 4, 64, 48);
  const View& view = s.scene.views[0];
  const Eigen::Vector3d towards = view.CenterInWorld().normalized();
  EXPECT_TRUE(SeesSurfacePoint(*s.shape, view, towards, towards));
  EXPECT_FALSE(SeesSurfacePoint(*s.shape, view, -towards, -towards));
  // A normal that lies: the far side is hidden by the near one.
  EXPECT_FALSE(SeesSurfacePoint(*s.shape, view, -towards, towards));
}

TEST(SampledCloud, PointsAreOnTheSurfaceAndSeenByTheirViews) {
  for (const ShapeName name : kAllNames) {
    const SyntheticScene s = MakeScene(name, 10, 160, 120);
    SampledCloudOptions options;
    options.num_points = 300;
    const VisibilityCloud cloud = SampleCloud(*s.shape, s.scene, options, RunContext());
    ASSERT_EQ(cloud.size(), 300u);
    cloud.CheckConsistent(s.scene.views.size());
    EXPECT_LT(MeasureCloud(cloud, s).max, 1e-5);
    for (size_t p = 0; p < cloud.size(); ++p) {
      EXPECT_GE(cloud.ViewsOf(p).size(), 2u);
      EXPECT_NEAR(cloud.normals[p].norm(), 1.0f, 1e-5f);
      for (const uint32_t v : cloud.ViewsOf(p)) {
        const View& view = s.scene.views[v];
        const Eigen::Vector3d x = cloud.positions[p].cast<double>();
        EXPECT_TRUE(view.camera.Contains(view.camera.Project(view.cam_from_world * x)));
        EXPECT_GT((view.CenterInWorld() - x).dot(cloud.normals[p].cast<double>()), 0);
      }
    }
  }
}

TEST(SampledCloud, NoiseOutliersAndMissesAreWhatWasAsked) {
  const SyntheticScene s = MakeScene(ShapeName::kSphere, 12, 160, 120);
  SampledCloudOptions options;
  options.num_points = 3000;
  const VisibilityCloud exact = SampleCloud(*s.shape, s.scene, options, RunContext());
  options.noise = 2 * s.gsd;
  const VisibilityCloud noisy = SampleCloud(*s.shape, s.scene, options, RunContext());
  // Along the normal: mean absolute value of a Gaussian = sigma * sqrt(2 / pi).
  EXPECT_NEAR(MeasureCloud(noisy, s).mean / (2 * s.gsd * 0.7979), 1.0, 0.05);
  options.outlier_fraction = 0.25;
  const VisibilityCloud dirty = SampleCloud(*s.shape, s.scene, options, RunContext());
  EXPECT_EQ(dirty.size(), 4000u);
  dirty.CheckConsistent(s.scene.views.size());
  for (size_t p = 3000; p < dirty.size(); ++p) EXPECT_GE(dirty.ViewsOf(p).size(), 2u);
  options.miss_probability = 0.5;
  const VisibilityCloud missed = SampleCloud(*s.shape, s.scene, options, RunContext());
  EXPECT_LT(missed.view_begin[3000], 0.8 * static_cast<double>(exact.view_begin[3000]));
}

TEST(SampledCloud, DensityVariesByTheRatio) {
  const SyntheticScene s = MakeScene(ShapeName::kStep, 12, 160, 120);
  SampledCloudOptions options;
  options.num_points = 4000;
  options.density_ratio = 100;
  const VisibilityCloud cloud = SampleCloud(*s.shape, s.scene, options, RunContext());
  double dense = 0, sparse = 0;
  for (const Eigen::Vector3f& x : cloud.positions) {
    dense += (x.x() > 0.5f && x.x() < 0.8f);
    sparse += (x.x() > -0.8f && x.x() < -0.5f);
  }
  // 1.3 apart of 3: 100^(1.3 / 3) = 7.4.
  EXPECT_NEAR(dense / sparse, 7.4, 2.5);
}

TEST(SampledCloud, SameForAnyNumberOfThreads) {
  const SyntheticScene s = MakeScene(ShapeName::kTorus, 8, 160, 120);
  SampledCloudOptions options;
  options.num_points = 2000;
  options.noise = s.gsd;
  options.outlier_fraction = 0.1;
  const VisibilityCloud one = SampleCloud(*s.shape, s.scene, options, RunContext(1));
  const VisibilityCloud two = SampleCloud(*s.shape, s.scene, options, RunContext(2));
  EXPECT_EQ(one.positions, two.positions);
  EXPECT_EQ(one.view_idxs, two.view_idxs);
}

TEST(SyntheticScene, EveryViewHasNeighborsAndTheGsdIsAPixel) {
  for (const ShapeName name : kAllNames) {
    SCOPED_TRACE(static_cast<int>(name));
    const SyntheticScene s = MakeScene(name, 12, 160, 120);
    EXPECT_EQ(s.scene.num_views(), 12);
    EXPECT_EQ(s.scene.points.size(), 2000u);
    EXPECT_NEAR(GroundSamplingDistance(s.scene) / s.gsd, 1.0, 0.05);
    for (const auto& neighbors : SelectNeighbors(s.scene, ViewSelectionOptions(), RunContext(2))) {
      EXPECT_GE(neighbors.size(), 2u);
    }
    for (const View& view : s.scene.views) {
      EXPECT_FALSE(s.shape->SignedDistance(view.CenterInWorld()) < 0.3);
    }
  }
}

TEST(SyntheticScene, LayoutsGiveTheNumberOfViewsAskedFor) {
  for (const CameraLayout layout : {CameraLayout::kRing, CameraLayout::kArc, CameraLayout::kGrid}) {
    for (const int num_views : {2, 7, 20}) {
      SCOPED_TRACE(num_views + 100 * static_cast<int>(layout));
      SyntheticSceneOptions options;
      options.shape = ShapeName::kRelief;
      options.layout = layout;
      options.num_views = num_views;
      options.num_sparse_points = 0;
      EXPECT_EQ(MakeScene(options, RunContext()).scene.num_views(), num_views);
    }
  }
}

TEST(SurfaceError, TruthAgainstItselfIsExactAndAShiftIsSeen) {
  const SyntheticScene s = MakeScene(ShapeName::kBox, 8, 160, 120);
  TriangleMesh mesh = s.shape->Mesh(0.2);
  const SurfaceError accuracy = MeasureAccuracy(mesh, s, 2, 2000);
  EXPECT_LT(accuracy.max, 1e-9);
  EXPECT_LT(accuracy.num_samples, 2000u);  // the bottom is not seen
  EXPECT_LT(MeasureCompleteness(mesh, s, 2, 2000).max, 1e-6);
  EXPECT_DOUBLE_EQ(accuracy.Within(1e-6), 1.0);
  for (Eigen::Vector3d& x : mesh.vertices) x *= 1.02;
  const SurfaceError grown = MeasureAccuracy(mesh, s, 0, 2000);
  EXPECT_GT(grown.bias, 0.01);
  EXPECT_LT(grown.max, 0.03);
}

TEST(SurfaceError, MissingPartLowersCompletenessOnly) {
  const SyntheticScene s = MakeScene(ShapeName::kSphere, 8, 160, 120);
  TriangleMesh mesh = s.shape->Mesh(0.1);
  std::erase_if(mesh.faces,
                [&](const Eigen::Vector3i& f) { return mesh.vertices[f[0]].x() > 0.0; });
  EXPECT_LT(MeasureAccuracy(mesh, s, 0, 2000).max, 0.01);
  const SurfaceError completeness = MeasureCompleteness(mesh, s, 2, 2000);
  EXPECT_NEAR(completeness.Within(0.03), 0.5, 0.06);
}

TEST(SyntheticSceneOptions, ChecksBounds) {
  SyntheticSceneOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.num_views = 0;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_NE(error.find("num_views"), std::string::npos);
}

}  // namespace
}  // namespace lsmvs
