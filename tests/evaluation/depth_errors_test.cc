#include "lsmvs/evaluation/depth_errors.h"

#include <gtest/gtest.h>

#include "lsmvs/test_evaluation/test_meshes.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

using test::PlaneMesh;

DepthErrors Measure(const TriangleMesh& mesh, const TriangleMesh& truth,
                    const std::vector<View>& views, const DepthErrorOptions& options = {}) {
  const RunContext context(2);
  return MeasureDepthErrors(MeshTracer(mesh, context), MeshTracer(truth, context), views, options,
                            context);
}

TEST(DepthErrors, OffsetPlaneFallsIntoOneBin) {
  // Depth 10, focal length 200: sigma is 0.05, the offset 0.12 is in [2, 3) sigma.
  const std::vector<View> views = {test::DownwardView({50, 50, 10}),
                                   test::DownwardView({60, 50, 10})};
  const DepthErrors errors = Measure(PlaneMesh(100, 100, 0.12), PlaneMesh(100, 100, 0), views);
  ASSERT_EQ(errors.views.size(), 2u);
  EXPECT_EQ(errors.views[0].bins[2], 100u * 100u);
  EXPECT_EQ(errors.views[0].Total(), 100u * 100u);
  EXPECT_EQ(errors.all.Total(), 2u * 100u * 100u);
  EXPECT_EQ(errors.all.ShareBelow(2), 0);
  EXPECT_EQ(errors.all.ShareBelow(3), 1);
  EXPECT_NEAR(errors.all.median_relative, 0.012, 1e-6);
}

TEST(DepthErrors, CountsMissingAndLarge) {
  // The truth fills the left half of the view; of it the reconstruction has a quarter, far off.
  const std::vector<View> views = {test::DownwardView({50, 50, 10}, 200, 200)};
  const DepthErrors errors = Measure(PlaneMesh(47.5, 100, -3), PlaneMesh(50, 100, 0), views);
  EXPECT_EQ(errors.all.Total(), 50u * 100u);
  EXPECT_EQ(errors.all.ShareBelow(10), 0);
  EXPECT_GT(errors.all.num_larger, 0u);
  EXPECT_EQ(errors.all.num_larger + errors.all.num_missing, 5000u);
}

TEST(DepthErrors, NothingSeenCountsNothing) {
  const DepthErrors errors =
      Measure(PlaneMesh(1, 1, 0), PlaneMesh(1, 1, 0), {test::DownwardView({500, 500, 10})});
  EXPECT_EQ(errors.all.Total(), 0u);
  EXPECT_EQ(errors.all.ShareBelow(1), 0);
}

TEST(DepthErrorOptions, BoundsAreNamed) {
  DepthErrorOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error));
  options.num_bins = 0;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_NE(error.find("num_bins"), std::string::npos);
  EXPECT_THROW(Measure({}, {}, {}, options), UsageError);
  options = {};
  options.sigma_px = 0;
  EXPECT_FALSE(options.Check(&error));
  options = {};
  options.pixel_step = 0;
  EXPECT_FALSE(options.Check(&error));
}

}  // namespace
}  // namespace lsmvs
