#include "lsmvs/refinement/finishing/region_rollback.h"

#include <gtest/gtest.h>

#include <random>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/refinement/step/level_optimizer.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

// A sphere with a pixel of noise, and refined ones that are better or worse.
class GuardedSphere : public testing::Test {
 protected:
  GuardedSphere() : s_(MakeScene(ShapeName::kSphere, 12, 160, 120)), context_(2) {
    WritePhotos(*s_.shape, s_.photo, folder_.path().string(), &s_.scene, context_);
    images_ = MakeImageStore(s_.scene, ImageStoreOptions());
    views_ = MakeLevelViews(s_.scene, *images_, 0);
    truth_ = s_.shape->Mesh(5 * s_.gsd);
    normals_ = ComputeVertexNormals(truth_);
    regions_ = GrowFaceRegions(truth_, 64);
    std::vector<ViewPair> pairs;
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 12; ++j) {
        if (i != j) pairs.push_back({i, j});
      }
    }
    pairs_ = SelectFacePairs(views_, pairs, truth_, regions_, PairSelectionOptions(), context_);
    input_ = Noisy(1.0, 1);
  }

  std::vector<Eigen::Vector3d> Noisy(double sigma_px, unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, sigma_px * s_.gsd);
    std::vector<Eigen::Vector3d> vertices = truth_.vertices;
    for (size_t v = 0; v < vertices.size(); ++v) {
      vertices[v] += noise(random) * normals_[v].cast<double>();
    }
    return vertices;
  }

  RollbackSummary Restore(TriangleMesh* mesh) const {
    return RollBackWorseRegions(*images_, views_, regions_, pairs_, input_, {},
                                PhotoEnergyOptions(), mesh, context_);
  }

  SyntheticScene s_;
  RunContext context_;
  TemporaryFolder folder_;
  std::unique_ptr<ImageStore> images_;
  std::vector<PosedCamera> views_;
  TriangleMesh truth_;
  std::vector<Eigen::Vector3f> normals_;
  FaceRegions regions_;
  FacePairs pairs_;
  std::vector<Eigen::Vector3d> input_;
};

TEST_F(GuardedSphere, KeepsWhatGotBetterAndRestoresWhatGotWorse) {
  const std::vector<Eigen::Vector3d> bad = Noisy(3.0, 2);
  TriangleMesh mesh = truth_;
  const double edge = 0.3;  // beyond which no region is of both halves
  for (size_t v = 0; v < bad.size(); ++v) {
    if (truth_.vertices[v].x() > 0) mesh.vertices[v] = bad[v];
  }
  const RollbackSummary summary = Restore(&mesh);
  EXPECT_GT(summary.num_regions_restored, 0u);
  EXPECT_LT(summary.output_error, summary.input_error);
  int num_restored = 0, num_bad = 0, num_kept = 0, num_good = 0;
  for (size_t v = 0; v < bad.size(); ++v) {
    const Eigen::Vector3d& x = truth_.vertices[v];
    if (x.z() < 0) continue;  // few views see it
    num_bad += x.x() > edge;
    num_restored += x.x() > edge && mesh.vertices[v] == input_[v];
    num_good += x.x() < -edge;
    num_kept += x.x() < -edge && mesh.vertices[v] == truth_.vertices[v];
  }
  ASSERT_GT(num_bad, 50);
  EXPECT_GT(num_restored, 0.85 * num_bad);
  EXPECT_GT(num_kept, 0.9 * num_good);
}

// Smoothness makes up for a small loss of photo-consistency, not for a large one.
TEST_F(GuardedSphere, SmoothnessOutweighsASmallLossOnly) {
  const auto num_restored = [&](double sigma_px, double gain_of_vertex) {
    TriangleMesh mesh = truth_;
    mesh.vertices = Noisy(sigma_px, 2);
    SmoothnessGain gain;
    gain.of_vertex.assign(mesh.vertices.size(), gain_of_vertex);
    return RollBackWorseRegions(*images_, views_, regions_, pairs_, input_, gain,
                                PhotoEnergyOptions(), &mesh, context_)
        .num_regions_restored;
  };
  EXPECT_LT(num_restored(1.02, 1e6), num_restored(1.02, 0));
  EXPECT_EQ(num_restored(1.02, -1e6), num_restored(1.02, 0));
  EXPECT_GT(num_restored(3.0, 1e6), static_cast<size_t>(regions_.count / 2));
}

TEST_F(GuardedSphere, TakesNothingBackWhereNothingGotWorse) {
  TriangleMesh mesh = truth_;
  // At the limb, regions of which few pixels are seen may go either way.
  EXPECT_LE(Restore(&mesh).num_regions_restored, static_cast<size_t>(regions_.count / 50));
  mesh.vertices = input_;
  EXPECT_EQ(Restore(&mesh).num_regions_restored, 0u);
  EXPECT_EQ(mesh.vertices, input_);
}

TEST_F(GuardedSphere, RestoringMakesNoFacesCross) {
  TriangleMesh mesh = truth_;
  mesh.vertices = Noisy(2.0, 3);
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  const auto crossings = [&](const std::vector<Eigen::Vector3d>& vertices) {
    return FaceGrid(vertices, mesh.faces).CrossingPairs(all, context_).size();
  };
  const size_t before = crossings(mesh.vertices);
  Restore(&mesh);
  EXPECT_LE(crossings(mesh.vertices), before);
}

}  // namespace
}  // namespace lsmvs
