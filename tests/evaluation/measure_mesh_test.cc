#include "lsmvs/evaluation/measure_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lsmvs/test_evaluation/test_meshes.h"

namespace lsmvs {
namespace {

const RunContext kContext(2);

SurfaceEvaluationOptions FewSamples() {
  SurfaceEvaluationOptions options;
  options.num_samples = 1000;
  return options;
}

TEST(MeasureMesh, DepthIsComparedWhereBothAreMeshesWithViews) {
  const TriangleMesh mesh = test::PlaneMesh(10, 10, 0.02), truth = test::PlaneMesh(10, 10, 0);
  const std::vector<View> views = {test::DownwardView({5, 5, 10}), test::DownwardView({6, 5, 10})};
  const SurfaceEvaluator evaluator(truth, views, FewSamples(), kContext);
  const MeshTracer tracer(mesh, kContext);
  MeshFigures figures;
  MeasureAgainstTruth(evaluator, mesh, &tracer, views, {}, kContext, &figures);
  ASSERT_TRUE(figures.surface && figures.depth_errors);
  EXPECT_NEAR(figures.surface->accuracy.mean, 0.02, 1e-6);
  // The plane is 10 away and 0.02 too near.
  EXPECT_NEAR(figures.depth_errors->all.median_relative, 0.002, 1e-6);

  const SurfaceEvaluation alone = evaluator.Evaluate(mesh, kContext, &tracer);
  EXPECT_EQ(figures.surface->accuracy.mean, alone.accuracy.mean);
  MeshFigures of_cloud;
  TriangleMesh cloud = mesh;
  cloud.faces.clear();
  MeasureAgainstTruth(evaluator, cloud, nullptr, views, {}, kContext, &of_cloud);
  EXPECT_TRUE(of_cloud.surface);
  EXPECT_FALSE(of_cloud.depth_errors);
}

TEST(MeasureMesh, DistancesAreThoseToThePlane) {
  const TriangleMesh truth = test::PlaneMesh(10, 10, 0);
  SurfaceEvaluationOptions options = FewSamples();
  options.unit = DistanceUnit::kWorld;
  options.min_num_views = 0;
  const SurfaceEvaluator evaluator(truth, {}, options, kContext);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> distances =
      DistancesToTruth(evaluator, {{5, 5, 0.25}, {5, 5, -3}, {nan, 0, 0}}, kContext);
  ASSERT_EQ(distances.size(), 3u);
  EXPECT_NEAR(distances[0], 0.25, 1e-6);
  EXPECT_NEAR(distances[1], 3, 1e-6);
  EXPECT_TRUE(std::isnan(distances[2]));
}

}  // namespace
}  // namespace lsmvs
