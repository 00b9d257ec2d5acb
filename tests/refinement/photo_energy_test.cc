#include "lsmvs/refinement/photo/photo_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/photo.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

constexpr int kWidth = 96, kHeight = 72;

// Smooth waves, different in each view: a derivative is exact whether or not the photos agree.
ColorImage Waves(int view) {
  ColorImage image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double value = 128 + 60 * std::sin(0.21 * x + 0.9 * view) * std::cos(0.17 * y) +
                           35 * std::sin(0.11 * (x + y) - 0.5 * view);
      image(x, y) = Color::Constant(static_cast<uint8_t>(value));
    }
  }
  return image;
}

// Three views from above of a bumpy ground that reaches beyond all of them, so that no border
// moves.
class GroundScene : public testing::Test {
 protected:
  GroundScene() : context_(1) {
    const PinholeCamera camera = MakeCamera(kWidth, kHeight);
    for (int v = 0; v < 3; ++v) {
      const Eigen::Vector3d center(0.6 * (v - 1), 0.2 * v, 3.0);
      views_.push_back({camera, LookAt(center, {0.1 * v, 0, 0})});
      const std::string path = (folder_.path() / (std::to_string(v) + ".png")).string();
      WriteImage(path, Waves(v));
      sources_.push_back({path, "", camera});
    }
    images_ = std::make_unique<ImageStore>(sources_, ImageStoreOptions());
    MakeGround();
  }

  void MakeGround() {
    constexpr int kSide = 25;
    std::mt19937 random(3);
    std::normal_distribution<double> bump(0, 0.02);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        mesh_.vertices.push_back({0.25 * (x - kSide / 2), 0.25 * (y - kSide / 2), bump(random)});
      }
    }
    for (int y = 0; y + 1 < kSide; ++y) {
      for (int x = 0; x + 1 < kSide; ++x) {
        const int a = y * kSide + x;
        mesh_.faces.push_back({a, a + 1, a + kSide});
        mesh_.faces.push_back({a + 1, a + kSide + 1, a + kSide});
      }
    }
    directions_.assign(mesh_.vertices.size(), Eigen::Vector3d(0.1, -0.2, 1).normalized());
  }

  // All pairs judge all faces.
  FacePairs AllPairs() const {
    FacePairs pairs;
    pairs.pairs = {{0, 1}, {0, 2}, {1, 0}, {2, 1}};
    pairs.per_face = 4;
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      for (int p = 0; p < 4; ++p) pairs.of_face.push_back(p);
    }
    return pairs;
  }

  PhotoTerms Evaluate(const TriangleMesh& mesh, const FacePairs& pairs) const {
    return EvaluatePhotoTerms(*images_, views_, mesh, directions_, pairs, {}, options_, context_);
  }

  RunContext context_;
  TemporaryFolder folder_;
  std::vector<PosedCamera> views_;
  std::vector<ImageSource> sources_;
  std::unique_ptr<ImageStore> images_;
  TriangleMesh mesh_;
  std::vector<Eigen::Vector3d> directions_;
  PhotoEnergyOptions options_;
};

TEST_F(GroundScene, GradientAgreesWithFiniteDifferencesAtEveryVertex) {
  options_.depth_tolerance = 0.1;
  const FacePairs pairs = AllPairs();
  const PhotoTerms terms = Evaluate(mesh_, pairs);
  double largest = 0;
  for (const double g : terms.gradient) largest = std::max(largest, std::abs(g));
  ASSERT_GT(largest, 0);
  // About a thirtieth of a pixel: the interpolant has kinks between pixels.
  const double step = 1e-3;
  int num_moving = 0;
  for (size_t v = 0; v < mesh_.vertices.size(); ++v) {
    if (std::abs(terms.gradient[v]) < 0.02 * largest) continue;
    TriangleMesh up = mesh_, down = mesh_;
    up.vertices[v] += step * directions_[v];
    down.vertices[v] -= step * directions_[v];
    const PhotoTerms terms_up = Evaluate(up, pairs), terms_down = Evaluate(down, pairs);
    // A pixel that leaves the other photo is a jump of the energy, not a slope.
    if (terms_up.mass != terms.mass || terms_down.mass != terms.mass) continue;
    const double numeric = (terms_up.TotalError() - terms_down.TotalError()) / (2 * step);
    EXPECT_NEAR(terms.gradient[v], numeric, 0.02 * largest) << "vertex " << v;
    ++num_moving;
  }
  EXPECT_GT(num_moving, 30);
}

TEST_F(GroundScene, ThreadsAndSmallBudgetsDoNotChangeABit) {
  const FacePairs pairs = AllPairs();
  const PhotoTerms one = Evaluate(mesh_, pairs);
  options_.map_budget_bytes = 1;
  const RunContext three(3);
  const PhotoTerms other =
      EvaluatePhotoTerms(*images_, views_, mesh_, directions_, pairs, {}, options_, three);
  EXPECT_EQ(one.gradient, other.gradient);
  EXPECT_EQ(one.curvature, other.curvature);
  EXPECT_EQ(one.error, other.error);
}

TEST_F(GroundScene, InactiveFacesAreLeftOut) {
  const FacePairs pairs = AllPairs();
  std::vector<uint8_t> active(mesh_.faces.size(), 0);
  for (size_t f = active.size() / 2; f < active.size(); ++f) active[f] = 1;
  const PhotoTerms all = Evaluate(mesh_, pairs);
  const PhotoTerms half =
      EvaluatePhotoTerms(*images_, views_, mesh_, directions_, pairs, active, options_, context_);
  for (size_t f = 0; f < active.size(); ++f) {
    EXPECT_NEAR(half.error[f], active[f] ? all.error[f] : 0.0f, 1e-3f);
  }
}

TEST_F(GroundScene, SelectionTakesPairsThatSeeAFace) {
  const FaceRegions regions = GrowFaceRegions(mesh_, 64);
  const FacePairs pairs = SelectFacePairs(views_, {{0, 1}, {1, 0}, {1, 2}}, mesh_, regions,
                                          PairSelectionOptions(), context_);
  const size_t middle = 2 * (12 * 24 + 12), corner = 0;
  EXPECT_TRUE(pairs.Seen(middle));
  EXPECT_FALSE(pairs.Seen(corner));
  EXPECT_GT(pairs.area_px[middle], 1);
  EXPECT_NEAR(pairs.pixel_size[middle], 3.0 / views_[0].camera.fx, 0.01);
}

}  // namespace
}  // namespace lsmvs
