#include "lsmvs/surface/memory_model.h"

#include <gtest/gtest.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <string>
#include <utility>

#include "lsmvs/surface/visibility_mesher.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"

namespace lsmvs {
namespace {

struct NoisySphere {
  NoisySphere() : scene(MakeScene(ShapeName::kSphere, 16, 1280, 960)) {
    SampledCloudOptions sampling;
    sampling.num_points = 120000;
    sampling.noise = 0.5 * scene.gsd;
    cloud = SampleCloud(*scene.shape, scene.scene, sampling, RunContext(2));
  }
  SyntheticScene scene;
  VisibilityCloud cloud;
};

VisibilityMesherResult MeshWith(double max_proj_dist) {
  ReturnLargeBlocksWhenFreed();
  NoisySphere sphere;
  VisibilityMesherOptions options;
  options.merging.max_proj_dist = max_proj_dist;
#if defined(__GLIBC__)
  malloc_trim(0);  // what making the cloud left behind would hold the mesher's small arrays
#endif
  return MeshVisibilityCloud(sphere.scene.scene, std::move(sphere.cloud), options, RunContext(1));
}

// The process' peak, whatever of it is due to pages and to the C library.
TEST(MemoryModel, ForetellsThePeakWithinAFifth) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "memory is counted without sanitizers";
#endif
  const VisibilityMesherResult result = MeshWith(0.1);
  ASSERT_GT(result.counters.num_vertices, 100000u);
  const auto measured = static_cast<double>(result.measured_peak_bytes);
  EXPECT_NEAR(static_cast<double>(result.predicted_peak_bytes), measured, 0.2 * measured);
}

// Vertices and their views, from the points of some places.
TEST(MemoryModel, ASampleTellsTheSize) {
  const NoisySphere sphere;
  CloudSampler sampler(sphere.scene.scene, {});
  for (size_t p = 0; p < sphere.cloud.size(); ++p) {
    sampler.Add(sphere.cloud.positions[p], sphere.cloud.normals[p], sphere.cloud.ViewsOf(p));
  }
  const CloudSample sample = sampler.Take();
  for (const double max_proj_dist : {0.1, 2.35, 6.0}) {
    VisibilityMesherOptions options;
    options.merging.max_proj_dist = max_proj_dist;
    const MeshingSize size = MeasureMeshingSize(sphere.scene.scene, sample, options, 1);
    EXPECT_EQ(size.num_points, sphere.cloud.size());
    EXPECT_EQ(size.num_view_entries, sphere.cloud.view_idxs.size());
    const VisibilityMesherCounters counters = MeshWith(max_proj_dist).counters;
    const auto near = [](size_t measured, size_t truth) {
      EXPECT_NEAR(static_cast<double>(measured), static_cast<double>(truth),
                  0.1 * static_cast<double>(truth));
    };
    near(size.num_vertices, counters.num_vertices);
    near(size.num_sights, counters.rays.num_rays);
  }
}

TEST(MemoryModel, SizesAreThoseOfTheRun) {
  const VisibilityMesherResult result = MeshWith(2.35);
  const VisibilityMesherCounters& counters = result.counters;
  const MeshingSize size{.num_points = counters.num_points,
                         .num_view_entries = 0,
                         .num_vertices = counters.num_vertices,
                         .num_sights = counters.rays.num_rays};
  // Cells near a surface: 6.75 a vertex.
  EXPECT_GT(size.CuttingBytes(), sizeof(float[16]) * counters.num_cells * 9 / 10);
  EXPECT_LT(counters.num_vertices, counters.num_points);
}

// With what the refusal names it fits.
TEST(MemoryModel, RefusalSaysWhatFits) {
  NoisySphere sphere;
  VisibilityMesherOptions options;
  options.merging.max_proj_dist = 6;
  RunContext context(1);
  const MeshingSize size{.num_points = sphere.cloud.size(),
                         .num_view_entries = sphere.cloud.view_idxs.size()};
  context.memory_budget_bytes = 2 * size.MergingBytes();
  std::string message;
  try {
    MeshVisibilityCloud(sphere.scene.scene, sphere.cloud, options, context);
  } catch (const MemoryError& error) {
    message = error.what();
  }
  const std::string option = "max_proj_dist to ";
  ASSERT_NE(message.find(option), std::string::npos) << message;
  options.merging.max_proj_dist = std::stod(message.substr(message.find(option) + option.size()));
  EXPECT_GT(options.merging.max_proj_dist, 6);
  EXPECT_NO_THROW(MeshVisibilityCloud(sphere.scene.scene, sphere.cloud, options, context));
}

}  // namespace
}  // namespace lsmvs
