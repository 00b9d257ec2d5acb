#include "lsmvs/evaluation/surface_evaluator.h"

#include <gtest/gtest.h>

#include <limits>

#include "lsmvs/test_evaluation/test_meshes.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

using test::PlaneMesh;
using test::SphereMesh;

SurfaceEvaluationOptions WorldOptions(const std::string& thresholds, double max_distance = 50) {
  SurfaceEvaluationOptions options;
  options.unit = DistanceUnit::kWorld;
  options.thresholds = thresholds;
  options.num_samples = 20000;
  options.max_distance = max_distance;
  return options;
}

TEST(SurfaceEvaluator, OffsetPlanesAreTheirOffsetApart) {
  const TriangleMesh truth = PlaneMesh(10, 10, 0), shifted = PlaneMesh(10, 10, 0.3);
  const SurfaceEvaluation result =
      EvaluateSurface(shifted, truth, {}, WorldOptions("0.29,0.31"), RunContext(2));
  EXPECT_EQ(result.status, SurfaceEvaluation::Status::kOk);
  for (const DistanceStatistics* s : {&result.accuracy, &result.completeness}) {
    EXPECT_NEAR(s->mean, 0.3, 1e-6);
    EXPECT_NEAR(s->median, 0.3, 1e-6);
    EXPECT_NEAR(s->percentile_95, 0.3, 1e-6);
    EXPECT_EQ(s->shares, (std::vector<double>{0, 1}));
  }
  EXPECT_EQ(result.f1, (std::vector<double>{0, 1}));
}

TEST(SurfaceEvaluator, SpheresOfTwoRadii) {
  const SurfaceEvaluation result =
      EvaluateSurface(SphereMesh(1.1), SphereMesh(1), {}, WorldOptions("0.09,0.11"), RunContext(2));
  // A mesh of 96 x 192 cells lies up to 1.3e-4 inside its sphere.
  EXPECT_NEAR(result.accuracy.mean, 0.1, 3e-4);
  EXPECT_NEAR(result.completeness.median, 0.1, 3e-4);
  EXPECT_EQ(result.f1, (std::vector<double>{0, 1}));
}

TEST(SurfaceEvaluator, HalfCoveredPlane) {
  // The reconstruction has the left half: all of it is right, and the missing half lies 0 to 5
  // away.
  const TriangleMesh truth = PlaneMesh(10, 10, 0), half = PlaneMesh(5, 10, 0);
  const SurfaceEvaluation result =
      EvaluateSurface(half, truth, {}, WorldOptions("0.001,1"), RunContext(2));
  const double sampling_error = 4 * 0.5 / std::sqrt(20000);
  EXPECT_EQ(result.accuracy.shares, (std::vector<double>{1, 1}));
  EXPECT_NEAR(result.completeness.shares[0], 0.5, sampling_error);
  EXPECT_NEAR(result.completeness.shares[1], 0.6, sampling_error);
  EXPECT_NEAR(result.f1[0], 2.0 / 3, sampling_error);
  EXPECT_NEAR(result.completeness.mean, 1.25, 0.05);
  EXPECT_NEAR(result.completeness.percentile_95, 4.5, 0.06);
}

TEST(SurfaceEvaluator, DistancesAreCutBeforeTheMean) {
  SurfaceEvaluationOptions options = WorldOptions("1");
  options.max_mean_distance = 2;
  options.max_distance = 7;
  const SurfaceEvaluation result =
      EvaluateSurface(PlaneMesh(1, 1, 100), PlaneMesh(1, 1, 0), {}, options, RunContext(1));
  EXPECT_DOUBLE_EQ(result.accuracy.mean, 2);
  EXPECT_DOUBLE_EQ(result.accuracy.median, 7);
}

TEST(SurfaceEvaluator, DoesNotDependOnTessellation) {
  const TriangleMesh truth = PlaneMesh(10, 10, 0, 1);
  TriangleMesh fine_half = PlaneMesh(5, 10, 0, 60), coarse_half = PlaneMesh(5, 10, 0.5, 1);
  // The right half, coarse, is 0.5 off: accuracy at 0.1 is one half although it has 2 of 7202
  // faces.
  const int first = static_cast<int>(fine_half.vertices.size());
  for (const Eigen::Vector3d& x : coarse_half.vertices)
    fine_half.vertices.push_back(x + Eigen::Vector3d(5, 0, 0));
  for (const Eigen::Vector3i& f : coarse_half.faces)
    fine_half.faces.push_back(f + Eigen::Vector3i::Constant(first));
  const SurfaceEvaluation result =
      EvaluateSurface(fine_half, truth, {}, WorldOptions("0.1"), RunContext(1));
  EXPECT_NEAR(result.accuracy.shares[0], 0.5, 0.015);
}

TEST(SurfaceEvaluator, CountsOnlyWhatCamerasSee) {
  // Two cameras over the left half of the ground; a wrong piece on the right is not judged.
  const std::vector<View> views = {test::DownwardView({2, 5, 10}, 60, 200),
                                   test::DownwardView({2.5, 5, 10}, 60, 200)};
  TriangleMesh truth = PlaneMesh(10, 10, 0), wrong_right = PlaneMesh(5, 10, 0);
  const TriangleMesh bad = test::Scaled(PlaneMesh(4, 10, 2), 1, {6, 0, 0});
  const int first = static_cast<int>(wrong_right.vertices.size());
  wrong_right.vertices.insert(wrong_right.vertices.end(), bad.vertices.begin(), bad.vertices.end());
  for (const Eigen::Vector3i& f : bad.faces)
    wrong_right.faces.push_back(f + Eigen::Vector3i::Constant(first));
  SurfaceEvaluationOptions options;
  options.num_samples = 20000;
  const SurfaceEvaluation result =
      EvaluateSurface(wrong_right, truth, views, options, RunContext(2));
  EXPECT_DOUBLE_EQ(result.gsd, 10.0 / 200);
  EXPECT_DOUBLE_EQ(result.unit_in_world, 10.0 / 200);
  EXPECT_EQ(result.f1[0], 1);
  EXPECT_GT(result.completeness.num_unseen, 10000u);

  options.min_num_views = 0;
  EXPECT_LT(EvaluateSurface(wrong_right, truth, views, options, RunContext(2)).f1[0], 0.9);
}

TEST(SurfaceEvaluator, CloudsAreJudgedByTheirPoints) {
  TriangleMesh cloud;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) cloud.vertices.emplace_back(0.05 + 0.1 * i, 0.05 + 0.1 * j, 0.02);
  }
  cloud.vertices.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  const SurfaceEvaluation result = EvaluateSurface(cloud, PlaneMesh(10, 10, 0), {},
                                                   WorldOptions("0.01,0.03,0.08"), RunContext(2));
  EXPECT_TRUE(result.is_cloud);
  EXPECT_EQ(result.num_not_finite, 1u);
  EXPECT_EQ(result.accuracy.num_points, 10000u);
  EXPECT_EQ(result.accuracy.shares, (std::vector<double>{0, 1, 1}));
  // A point of the ground is right if it lies within sqrt(0.03^2 - 0.02^2) of a point of the grid
  // of 0.1.
  EXPECT_NEAR(result.completeness.shares[1], std::numbers::pi * (9 - 4) / 100, 0.015);
  EXPECT_EQ(result.completeness.shares[2], 1);
}

// A clump of wrong points counts by the area that it covers, not by their number.
TEST(SurfaceEvaluator, AccuracyOfACloudGoesByArea) {
  TriangleMesh cloud;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) cloud.vertices.emplace_back(0.05 + 0.1 * i, 0.05 + 0.1 * j, 0);
  }
  for (int k = 0; k < 20000; ++k) cloud.vertices.emplace_back(5, 5 + 1e-7 * k, 1);
  const SurfaceEvaluation result =
      EvaluateSurface(cloud, PlaneMesh(10, 10, 0), {}, SurfaceEvaluationOptions(), RunContext(1));
  EXPECT_NEAR(result.accuracy.shares[1], 10000.0 / 10001.0, 2e-4);
}

TEST(SurfaceEvaluator, TruthMayBeACloud) {
  TriangleMesh scan = PlaneMesh(10, 10, 0, 100);
  scan.faces.clear();
  const SurfaceEvaluation result =
      EvaluateSurface(PlaneMesh(10, 10, 0.5), scan, {}, WorldOptions("0.4,0.6"), RunContext(2));
  EXPECT_EQ(result.f1, (std::vector<double>{0, 1}));
}

TEST(SurfaceEvaluator, ScaleAndPlaceOfTheSceneChangeNothing) {
  const auto score = [](double scale, const Eigen::Vector3d& shift) {
    std::vector<View> views;
    for (const double x : {3.0, 7.0})
      views.push_back(test::DownwardView(scale * Eigen::Vector3d(x, 5, 10) + shift));
    SurfaceEvaluationOptions options;
    options.num_samples = 5000;
    return EvaluateSurface(
        test::Scaled(SphereMesh(4, 24), scale, 5 * scale * Eigen::Vector3d(1, 1, 0) + shift),
        test::Scaled(SphereMesh(4.1, 24), scale, 5 * scale * Eigen::Vector3d(1, 1, 0) + shift),
        views, options, RunContext(2));
  };
  const SurfaceEvaluation a = score(1, {0, 0, 0}), b = score(1000, {4.5e5, 5.4e6, 0});
  for (size_t k = 0; k < a.f1.size(); ++k) EXPECT_NEAR(a.f1[k], b.f1[k], 2e-3);
}

TEST(SurfaceEvaluator, ThreadsChangeNothing) {
  const std::vector<View> views = {test::DownwardView({5, 5, 10}), test::DownwardView({6, 5, 10})};
  const auto score = [&](int threads) {
    SurfaceEvaluationOptions options;
    options.num_samples = 10000;
    return EvaluateSurface(test::Scaled(SphereMesh(2, 30), 1, {5, 5, 0}), PlaneMesh(10, 10, 1),
                           views, options, RunContext(threads));
  };
  const SurfaceEvaluation one = score(1), two = score(2);
  EXPECT_EQ(one.f1, two.f1);
  EXPECT_EQ(one.accuracy.mean, two.accuracy.mean);
  EXPECT_EQ(one.completeness.percentile_95, two.completeness.percentile_95);
}

TEST(SurfaceEvaluator, NothingToScoreIsAStatus) {
  const TriangleMesh plane = PlaneMesh(10, 10, 0), nothing;
  const SurfaceEvaluationOptions options = WorldOptions("1");
  EXPECT_EQ(EvaluateSurface(nothing, plane, {}, options, RunContext(1)).status,
            SurfaceEvaluation::Status::kEmptyReconstruction);
  EXPECT_EQ(EvaluateSurface(plane, nothing, {}, options, RunContext(1)).status,
            SurfaceEvaluation::Status::kEmptyTruth);
  const std::vector<View> views = {test::DownwardView({5, 5, 10}), test::DownwardView({6, 5, 10})};
  const TriangleMesh aside = test::Scaled(plane, 1, {1000, 0, 0});
  const SurfaceEvaluation unseen = EvaluateSurface(aside, plane, views, options, RunContext(1));
  EXPECT_EQ(unseen.status, SurfaceEvaluation::Status::kNothingSeen);
  EXPECT_EQ(unseen.f1[0], 0);
}

TEST(SurfaceEvaluationOptions, DefaultsAreValidAndBoundsAreNamed) {
  std::string error;
  EXPECT_TRUE(SurfaceEvaluationOptions().Check(&error)) << error;
  const auto violation = [](const auto& change) {
    SurfaceEvaluationOptions options;
    change(&options);
    std::string message;
    EXPECT_FALSE(options.Check(&message));
    return message;
  };
  using O = SurfaceEvaluationOptions;
  for (const char* bad : {"", "0", "1,", "2,1", "-1", "x", "1;2", "1,1", "nan", "inf"}) {
    EXPECT_NE(violation([bad](O* o) { o->thresholds = bad; }).find("thresholds"),
              std::string::npos);
  }
  EXPECT_NE(violation([](O* o) { o->max_distance = 3; }).find("max_distance"), std::string::npos);
  EXPECT_NE(violation([](O* o) { o->num_samples = 0; }).find("num_samples"), std::string::npos);
  EXPECT_NE(violation([](O* o) { o->min_num_views = -1; }).find("min_num_views"),
            std::string::npos);
  EXPECT_NE(violation([](O* o) { o->visibility_tolerance_gsd = -1; }).find("visibility"),
            std::string::npos);
  EXPECT_NE(violation([](O* o) { o->max_mean_distance = 0; }).find("max_mean_distance"),
            std::string::npos);
  SurfaceEvaluationOptions bad;
  bad.num_samples = 0;
  EXPECT_THROW(EvaluateSurface({}, {}, {}, bad, RunContext(1)), UsageError);
}

TEST(SurfaceEvaluator, EstimateGrowsWithTheWork) {
  const SurfaceEvaluationOptions options;
  const CostEstimate small = EstimateSurfaceEvaluation(1000, 1000, 4, options);
  const CostEstimate large = EstimateSurfaceEvaluation(1000000, 1000000, 40, options);
  EXPECT_GT(small.cpu_seconds, 0);
  EXPECT_GT(large.cpu_seconds, small.cpu_seconds);
  EXPECT_GT(large.peak_bytes, small.peak_bytes);
}

}  // namespace
}  // namespace lsmvs
