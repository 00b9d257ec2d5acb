#include "lsmvs/refinement/refinement_worker.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

// A helper in this process, that computes the items whose number `is_helped` says.
class HelperInTheSameProcess : public LoopHelpers {
 public:
  HelperInTheSameProcess(std::unique_ptr<LoopWorker> worker, std::function<bool(size_t)> is_helped)
      : worker_(std::move(worker)), is_helped_(std::move(is_helped)) {}

  void Run(const SharedLoop& loop, const RunContext& context) override {
    for (const LoopState& state : loop.states()) {
      if (sent_[state.key] != *state.bytes) worker_->SetState(state.key, *state.bytes);
      sent_[state.key] = *state.bytes;
    }
    worker_->Begin(loop.kind);
    ParallelFor(context, loop.count, 1, [&](size_t item) {
      if (is_helped_(item)) {
        loop.keep(item, worker_->Compute(loop.kind, item));
      } else {
        loop.compute(item, [] { return true; });
      }
    });
    for (size_t item = 0; item < loop.count; ++item) num_helped[loop.kind] += is_helped_(item);
  }

  std::map<int, size_t> num_helped;  // by kind of loop

 private:
  std::unique_ptr<LoopWorker> worker_;
  const std::function<bool(size_t)> is_helped_;
  std::map<int, std::string> sent_;
};

struct NoisySphere {
  NoisySphere() : s(MakeScene(ShapeName::kSphere, 8, 128, 96)) {
    WritePhotos(*s.shape, s.photo, folder.path().string(), &s.scene, RunContext());
    images = MakeImageStore(s.scene, ImageStoreOptions());
    helper_images = MakeImageStore(s.scene, ImageStoreOptions());
    mesh = s.shape->Mesh(3 * s.gsd);
    const std::vector<Eigen::Vector3f> normals = ComputeVertexNormals(mesh);
    std::mt19937 random(4);
    std::normal_distribution<double> noise(0, s.gsd);
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
      mesh.vertices[v] += noise(random) * normals[v].cast<double>();
    }
  }
  TemporaryFolder folder;
  SyntheticScene s;
  std::unique_ptr<ImageStore> images, helper_images;
  TriangleMesh mesh;
};

class RefinementWithHelper : public testing::TestWithParam<RefinementOptimizer> {};

TEST_P(RefinementWithHelper, GivesTheSameBytes) {
  const NoisySphere scene;
  MeshRefinerOptions options;
  options.optimizer = GetParam();
  options.num_levels = 2;
  const RefinementResult alone =
      RefineMesh(scene.s.scene, *scene.images, scene.mesh, options, RunContext(2));
  const std::map<std::string, std::function<bool(size_t)>> shares = {
      {"none", [](size_t) { return false; }},
      {"every second", [](size_t item) { return item % 2 == 1; }},
      {"all", [](size_t) { return true; }}};
  for (const auto& [name, is_helped] : shares) {
    const RunContext helper_context(2);
    HelperInTheSameProcess helper(
        MakeRefinementWorker(scene.s.scene, *scene.helper_images, options, helper_context),
        is_helped);
    RunContext context(2);
    context.helpers = &helper;
    const RefinementResult helped =
        RefineMesh(scene.s.scene, *scene.images, scene.mesh, options, context);
    EXPECT_EQ(helped.mesh.vertices, alone.mesh.vertices) << name;
    EXPECT_EQ(helped.mesh.faces, alone.mesh.faces) << name;
    EXPECT_EQ(helped.mesh.vertex_quality, alone.mesh.vertex_quality) << name;
    EXPECT_EQ(helped.output_photo_error, alone.output_photo_error) << name;
    if (name == "none") continue;
    ASSERT_EQ(helper.num_helped.size(), 2u);  // both loops
    for (const auto& [kind, count] : helper.num_helped) EXPECT_GT(count, 0u) << kind;
  }
}

INSTANTIATE_TEST_SUITE_P(Optimizers, RefinementWithHelper,
                         testing::Values(RefinementOptimizer::kGaussNewton,
                                         RefinementOptimizer::kLbfgs),
                         [](const auto& tested) {
                           return tested.param == RefinementOptimizer::kLbfgs ? "Lbfgs"
                                                                              : "GaussNewton";
                         });

}  // namespace
}  // namespace lsmvs
