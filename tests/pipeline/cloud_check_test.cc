#include "lsmvs/pipeline/tasks/cloud_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "lsmvs/surface/visibility_mesher.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

using testing::HasSubstr;

struct SeenSphere {
  SeenSphere() : scene(MakeScene(ShapeName::kSphere, 12, 640, 480)) {
    SampledCloudOptions sampling;
    sampling.num_points = 8000;
    sampling.noise = 0.3 * scene.gsd;
    cloud = SampleCloud(*scene.shape, scene.scene, sampling, RunContext(1));
  }
  // What the surface stage would say.
  std::string Warning() const {
    VisibilityMesherOptions options;
    options.merging.max_proj_dist = 0.1;  // the sample is sparse: each point counts
    const VisibilityMesherResult result =
        MeshVisibilityCloud(scene.scene, cloud, options, RunContext(1));
    return ContradictionWarning(MeasureCloudFit(scene.scene, cloud), result.counters.num_vertices,
                                result.mesh.vertices.size());
  }
  SyntheticScene scene;
  VisibilityCloud cloud;
};

TEST(CloudCheck, AGoodCloudRaisesNoWarning) {
  const SeenSphere sphere;
  const CloudFit fit = MeasureCloudFit(sphere.scene.scene, sphere.cloud);
  EXPECT_GT(fit.inside, 0.99);
  EXPECT_GT(fit.facing, 0.99);
  EXPECT_EQ(sphere.Warning(), "");
}

// As when a visibility file counts images in another order.
TEST(CloudCheck, ViewsInTheWrongOrderAreNamed) {
  SeenSphere sphere;
  for (uint32_t& view_idx : sphere.cloud.view_idxs) view_idx = (view_idx + 6) % 12;
  for (size_t p = 0; p < sphere.cloud.size(); ++p) {
    std::sort(
        sphere.cloud.view_idxs.begin() + static_cast<std::ptrdiff_t>(sphere.cloud.view_begin[p]),
        sphere.cloud.view_idxs.begin() +
            static_cast<std::ptrdiff_t>(sphere.cloud.view_begin[p + 1]));
  }
  const std::string warning = sphere.Warning();
  EXPECT_THAT(warning, HasSubstr("on the surface"));
  EXPECT_THAT(warning, HasSubstr("another order"));
}

// Depths that have nothing to do with the views.
TEST(CloudCheck, NoiseIsNamed) {
  SeenSphere sphere;
  for (size_t p = 0; p < sphere.cloud.size(); ++p) {
    // Along the ray of the first view that sees it, so that it stays in that image.
    const View& view = sphere.scene.scene.views[sphere.cloud.ViewsOf(p)[0]];
    const Eigen::Vector3f center = view.CenterInWorld().cast<float>();
    const float factor = 0.75f + 0.5f * static_cast<float>((p * 7919) % 1000) / 1000;
    sphere.cloud.positions[p] = center + factor * (sphere.cloud.positions[p] - center);
  }
  EXPECT_THAT(sphere.Warning(), HasSubstr("on the surface"));
}

// The surface has nearly all places, since the views see it as before.
TEST(CloudCheck, NormalsInsideOutAreNamed) {
  SeenSphere sphere;
  for (Eigen::Vector3f& normal : sphere.cloud.normals) normal = -normal;
  EXPECT_THAT(sphere.Warning(), HasSubstr("inside out"));
}

TEST(CloudCheck, AFitThatIsBadIsNamedHoweverLargeTheSurface) {
  EXPECT_EQ(ContradictionWarning({0.95, 0.95}, 1000, 900), "");
  const std::string warning = ContradictionWarning({0.79, 0.97}, 1000, 900);
  for (const char* text : {"79 %", "97 %", "do not fit", "another order"}) {
    EXPECT_THAT(warning, HasSubstr(text));
  }
  EXPECT_THAT(ContradictionWarning({1.0, 0.0}, 1000, 900), HasSubstr("inside out"));
}

TEST(CloudCheck, SaysTheFigures) {
  EXPECT_EQ(ContradictionWarning({1, 1}, 1000, 300), "");
  const std::string warning = ContradictionWarning({0.62, 0.4}, 1000, 12);
  for (const char* text : {"12 of 1000", "1.2 %", "62 %", "40 %", "poses"}) {
    EXPECT_THAT(warning, HasSubstr(text));
  }
  EXPECT_THAT(ContradictionWarning({0.99, 0.4}, 1000, 12), HasSubstr("normals"));
  EXPECT_THAT(ContradictionWarning({0.99, 0.99}, 1000, 12), HasSubstr("depths"));
}

}  // namespace
}  // namespace lsmvs
