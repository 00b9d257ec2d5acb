#include "lsmvs/refinement/mesh_refiner.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <atomic>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/checkpoint_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

// Photos on disk of a shape with exact truth.
struct RenderedScene {
  explicit RenderedScene(const SyntheticScene& synthetic) : s(synthetic) {
    WritePhotos(*s.shape, s.photo, folder.path().string(), &s.scene, RunContext());
    images = MakeImageStore(s.scene, ImageStoreOptions());
  }
  TemporaryFolder folder;
  SyntheticScene s;
  std::unique_ptr<ImageStore> images;
};

SyntheticScene SphereScene() { return MakeScene(ShapeName::kSphere, 24, 160, 120); }

TriangleMesh WithNoise(TriangleMesh mesh, double sigma, unsigned seed) {
  const std::vector<Eigen::Vector3f> normals = ComputeVertexNormals(mesh);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    mesh.vertices[v] += noise(random) * normals[v].cast<double>();
  }
  return mesh;
}

// Mean distance (pixels) to the truth of the vertices above the part that no view sees.
double MeanErrorPx(const SyntheticScene& s, const TriangleMesh& mesh, double min_z = -0.3) {
  double sum = 0;
  int count = 0;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    if (x.z() < min_z) continue;
    sum += std::abs(s.shape->SignedDistance(x)) / s.gsd;
    ++count;
  }
  return sum / count;
}

// Of the refinement alone: what it finds is not simplified.
MeshRefinerOptions FastOptions() {
  MeshRefinerOptions options;
  options.simplify_tolerance = 0;
  options.num_levels = 2;
  options.color_vertices = false;
  return options;
}

TEST(MeshRefiner, SphereWithTwoPixelsOfNoiseComesBack) {
  const RenderedScene scene(SphereScene());
  const TriangleMesh noisy = WithNoise(scene.s.shape->Mesh(10 * scene.s.gsd), 2 * scene.s.gsd, 1);
  const RefinementResult result =
      RefineMesh(scene.s.scene, *scene.images, noisy, FastOptions(), RunContext(2));
  ExpectValidClosedMesh(result.mesh);
  EXPECT_GT(MeanErrorPx(scene.s, noisy), 1.4);
  EXPECT_LT(MeanErrorPx(scene.s, result.mesh), 0.3);
  EXPECT_EQ(result.status, RefinementStatus::kRefined);
}

TEST(MeshRefiner, TheTrueMeshStays) {
  const RenderedScene scene(SphereScene());
  const TriangleMesh truth = scene.s.shape->Mesh(4 * scene.s.gsd);
  const RefinementResult result =
      RefineMesh(scene.s.scene, *scene.images, truth, FastOptions(), RunContext(2));
  EXPECT_LT(MeanErrorPx(scene.s, result.mesh), 0.2);
}

TEST(MeshRefiner, ThreadsDoNotChangeABit) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 6, 96, 72));
  const TriangleMesh noisy = WithNoise(scene.s.shape->Mesh(5 * scene.s.gsd), scene.s.gsd, 2);
  const auto one = RefineMesh(scene.s.scene, *scene.images, noisy, FastOptions(), RunContext(1));
  const auto three = RefineMesh(scene.s.scene, *scene.images, noisy, FastOptions(), RunContext(3));
  EXPECT_EQ(one.mesh.vertices, three.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, three.mesh.faces);
}

// Distances (pixels) of the vertices that can be judged: mean and share above one pixel.
struct Accuracy {
  double mean = 0, share_above_one = 0;
};

Accuracy Measure(const SyntheticScene& s, const TriangleMesh& mesh) {
  Accuracy accuracy;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    const double distance = std::abs(s.shape->SignedDistance(x)) / s.gsd;
    accuracy.mean += distance / static_cast<double>(mesh.vertices.size());
    accuracy.share_above_one += (distance > 1.0) / static_cast<double>(mesh.vertices.size());
  }
  return accuracy;
}

size_t NumCrossings(const TriangleMesh& mesh) {
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  return FaceGrid(mesh.vertices, mesh.faces).CrossingPairs(all, RunContext(1)).size();
}

// The noise of the photos does not become the surface's: away from what stands on it, the ground is
// flat.
TEST(MeshRefiner, FlatGroundOfNoisyPhotosComesOutFlatter) {
  SyntheticScene synthetic = MakeScene(ShapeName::kSphereOnGround, 10, 160, 120);
  synthetic.photo.noise_sigma = 6;
  const RenderedScene scene(synthetic);
  const TriangleMesh input = WithNoise(scene.s.shape->Mesh(4 * scene.s.gsd), 0.5 * scene.s.gsd, 4);
  const auto refine = [&](double flat_stiffness) {
    MeshRefinerOptions options = FastOptions();
    options.flat_stiffness = flat_stiffness;
    return RefineMesh(scene.s.scene, *scene.images, input, options, RunContext(2)).mesh;
  };
  // Root of the mean squared height (pixels) of the ground's vertices, apart from the sphere and
  // the rim.
  const auto roughness = [&](const TriangleMesh& mesh) {
    double sum = 0;
    int count = 0;
    for (const Eigen::Vector3d& x : mesh.vertices) {
      const double height = x.z() / scene.s.gsd;
      if (std::abs(height) > 3 || x.head<2>().norm() < 0.9 || x.head<2>().norm() > 1.4) continue;
      sum += height * height;
      ++count;
    }
    EXPECT_GT(count, 500);
    return std::sqrt(sum / count);
  };
  const TriangleMesh uniform = refine(1.0), by_crease = refine(30.0);
  EXPECT_LT(roughness(by_crease), 0.8 * roughness(uniform));
  EXPECT_LE(Measure(scene.s, by_crease).mean, Measure(scene.s, uniform).mean);
}

struct Trouble {
  std::string name;
  ShapeName shape;
  void (*make)(PhotoOptions* photo);
};

class RefinementUnderTrouble : public testing::TestWithParam<Trouble> {};

TEST_P(RefinementUnderTrouble, IsNoWorseThanItsInput) {
  SyntheticScene synthetic = MakeScene(GetParam().shape, 10, 128, 96);
  GetParam().make(&synthetic.photo);
  const RenderedScene scene(synthetic);
  const TriangleMesh input = WithNoise(scene.s.shape->Mesh(8 * scene.s.gsd), 0.3 * scene.s.gsd, 3);
  const RefinementResult result =
      RefineMesh(scene.s.scene, *scene.images, input, FastOptions(), RunContext(2));
  ExpectValidMesh(result.mesh);
  const Accuracy before = Measure(scene.s, input), after = Measure(scene.s, result.mesh);
  EXPECT_LE(after.mean, before.mean);
  // In creases and at silhouettes of so small photos single vertices go further.
  EXPECT_LE(after.share_above_one, before.share_above_one + 0.01);
  if (NumCrossings(input) == 0) {
    EXPECT_EQ(NumCrossings(result.mesh), 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Rendered, RefinementUnderTrouble,
                         testing::Values(Trouble{"exposure", ShapeName::kRelief,
                                                 [](PhotoOptions* p) { p->exposure_step = 0.8; }},
                                         Trouble{"shadow", ShapeName::kSphereOnGround,
                                                 [](PhotoOptions* p) { p->moving_shadow = 0.4; }},
                                         Trouble{"specular", ShapeName::kSphereOnGround,
                                                 [](PhotoOptions* p) { p->specular = 0.7; }},
                                         Trouble{"noise", ShapeName::kStep,
                                                 [](PhotoOptions* p) { p->noise_sigma = 4; }},
                                         Trouble{"thin", ShapeName::kPole, [](PhotoOptions*) {}},
                                         Trouble{"untextured", ShapeName::kRelief,
                                                 [](PhotoOptions* p) {
                                                   p->texture.contrast = 0.02;
                                                   p->noise_sigma = 2;
                                                 }}),
                         [](const auto& test) { return test.param.name; });

TEST(MeshRefiner, ScaleAndRotationOfTheSceneChangeNothing) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 10, 96, 72));
  const TriangleMesh noisy = WithNoise(scene.s.shape->Mesh(8 * scene.s.gsd), scene.s.gsd, 2);
  const auto base = RefineMesh(scene.s.scene, *scene.images, noisy, FastOptions(), RunContext(2));
  const double scale = 250;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(40, -900, 300);
  Scene moved_scene = scene.s.scene;
  TriangleMesh moved = noisy;
  const auto move = [&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(scale * (turn * x) + shift);
  };
  for (Eigen::Vector3d& x : moved.vertices) x = move(x);
  for (SparsePoint& point : moved_scene.points) point.x_in_world = move(point.x_in_world);
  for (View& view : moved_scene.views) {
    const Eigen::Vector3d center = move(view.CenterInWorld());
    view.cam_from_world.rotation = view.cam_from_world.rotation * turn.transpose();
    view.cam_from_world.translation = -(view.cam_from_world.rotation * center);
  }
  const auto other = RefineMesh(moved_scene, *scene.images, moved, FastOptions(), RunContext(2));
  // Rounding may flip an edge or a comparison: the surface is the same to a small part of a pixel.
  ASSERT_NEAR(static_cast<double>(other.mesh.vertices.size()),
              static_cast<double>(base.mesh.vertices.size()),
              0.01 * static_cast<double>(base.mesh.vertices.size()));
  double difference = 0;
  for (const Eigen::Vector3d& x : other.mesh.vertices) {
    const Eigen::Vector3d back = turn.transpose() * (x - shift) / scale;
    difference += std::abs(scene.s.shape->SignedDistance(back)) / scene.s.gsd /
                  static_cast<double>(other.mesh.vertices.size());
  }
  EXPECT_NEAR(difference, Measure(scene.s, base.mesh).mean, 0.01);
}

// Regions stop one by one: those of a sphere that is true on one side before those with noise.
TEST(MeshRefiner, RegionsThatHaveConvergedStopBeforeTheOthers) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 10, 128, 96));
  const TriangleMesh truth = scene.s.shape->Mesh(5 * scene.s.gsd);
  TriangleMesh mesh = WithNoise(truth, 1.5 * scene.s.gsd, 7);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (truth.vertices[v].x() > 0) mesh.vertices[v] = truth.vertices[v];
  }
  MeshRefinerOptions options = FastOptions();
  options.num_levels = 1;
  options.max_num_iterations = 3;
  options.min_relative_gain = 0.01;
  const auto result = RefineMesh(scene.s.scene, *scene.images, mesh, options, RunContext(2));
  const RefinementLevelSummary& level = result.levels.front();
  EXPECT_GT(level.num_stopped_regions, level.num_regions / 8);
  EXPECT_LT(level.num_stopped_regions, level.num_regions);
  options.max_num_iterations = 20;
  const auto long_run = RefineMesh(scene.s.scene, *scene.images, mesh, options, RunContext(2));
  EXPECT_LT(long_run.levels.front().num_iterations, 20);
  EXPECT_GT(long_run.levels.front().num_stopped_regions, level.num_stopped_regions);
}

// Views that took no part confirm what the others found.
TEST(MeshRefiner, HeldOutViewsJudge) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 16, 128, 96));
  const TriangleMesh noisy = WithNoise(scene.s.shape->Mesh(6 * scene.s.gsd), scene.s.gsd, 8);
  MeshRefinerOptions options = FastOptions();
  options.hold_out_every = 4;
  const auto result = RefineMesh(scene.s.scene, *scene.images, noisy, options, RunContext(2));
  EXPECT_LT(result.output_photo_error, 0.8 * result.input_photo_error);
  EXPECT_LT(result.num_regions_restored, result.num_regions / 10);
  EXPECT_LT(MeanErrorPx(scene.s, result.mesh), 0.3);
}

double BorderLength(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> sides;
  for (const Eigen::Vector3i& f : mesh.faces) {
    for (int k = 0; k < 3; ++k) ++sides[std::minmax(f[k], f[(k + 1) % 3])];
  }
  double length = 0;
  for (const auto& [ends, count] : sides) {
    if (count > 1) continue;
    length += (mesh.vertices[static_cast<size_t>(ends.first)] -
               mesh.vertices[static_cast<size_t>(ends.second)])
                  .norm();
  }
  return length;
}

// Large faces at the border are split with their border edges: there are more of them afterwards,
// but the border itself is no longer, and no new one appears.
TEST(MeshRefiner, KeepsTheBorder) {
  const RenderedScene scene(MakeScene(ShapeName::kRelief, 8, 128, 96));
  const TriangleMesh input = WithNoise(scene.s.shape->Mesh(20 * scene.s.gsd), 0.3 * scene.s.gsd, 5);
  const auto result = RefineMesh(scene.s.scene, *scene.images, input, FastOptions(), RunContext(2));
  ExpectValidMesh(result.mesh);
  EXPECT_GT(result.num_splits, 0u);
  const MeshInspection before = Inspect(input), after = Inspect(result.mesh);
  EXPECT_EQ(after.euler_characteristic, before.euler_characteristic);
  EXPECT_EQ(after.num_components, before.num_components);
  EXPECT_NEAR(BorderLength(result.mesh), BorderLength(input), 0.02 * BorderLength(input));
}

TEST(MeshRefiner, LbfgsFindsTheSurfaceToo) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 8, 96, 72));
  const TriangleMesh noisy = WithNoise(scene.s.shape->Mesh(8 * scene.s.gsd), scene.s.gsd, 6);
  MeshRefinerOptions options = FastOptions();
  options.optimizer = RefinementOptimizer::kLbfgs;
  options.max_num_iterations = 30;
  const auto result = RefineMesh(scene.s.scene, *scene.images, noisy, options, RunContext(2));
  ExpectValidClosedMesh(result.mesh);
  EXPECT_LT(MeanErrorPx(scene.s, result.mesh), 0.6 * MeanErrorPx(scene.s, noisy));
  for (const RefinementLevelSummary& level : result.levels) {
    EXPECT_LT(level.energies.back(), level.energies.front());
  }
}

TEST(MeshRefiner, SequentialDeformationFindsWhatTheIndependentOneFinds) {
  // Of more than one cluster.
  const RenderedScene scene(MakeScene(ShapeName::kRelief, 6, 480, 360));
  const TriangleMesh noisy = WithNoise(scene.s.shape->Mesh(8 * scene.s.gsd), 0.7 * scene.s.gsd, 4);
  ASSERT_GT(noisy.faces.size(), size_t{3} << 14);
  MeshRefinerOptions options = FastOptions();
  options.num_levels = 1;
  options.guard = false;
  options.improve_mesh = false;
  options.max_face_area_px = 0;
  // What is minimised is the same in all steps, so that energies can be compared.
  options.flat_stiffness = 1;
  const auto together = RefineMesh(scene.s.scene, *scene.images, noisy, options, RunContext(2));
  options.deformation = RefinementDeformation::kSequential;
  const auto in_turn = RefineMesh(scene.s.scene, *scene.images, noisy, options, RunContext(2));
  ExpectValidMesh(in_turn.mesh);
  EXPECT_NE(in_turn.mesh.vertices, together.mesh.vertices);
  const double before = Measure(scene.s, noisy).mean, after = Measure(scene.s, in_turn.mesh).mean;
  EXPECT_LT(after, 0.8 * before);
  EXPECT_NEAR(after, Measure(scene.s, together.mesh).mean, 0.1 * before);
  const std::vector<double>& energies = in_turn.levels.at(0).energies;
  for (size_t k = 1; k < energies.size(); ++k) EXPECT_LT(energies[k], energies[k - 1]) << k;
}

TEST(MeshRefiner, GoesOnBehindTheLevelsThatWereFinished) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 6, 160, 120));
  const TriangleMesh noisy = WithNoise(scene.s.shape->Mesh(5 * scene.s.gsd), scene.s.gsd, 2);
  const auto whole = RefineMesh(scene.s.scene, *scene.images, noisy, FastOptions(), RunContext(2));
  const TemporaryFolder folder;
  const CheckpointFolder checkpoints(folder.path() / "steps");
  // The first start is stopped behind the first level.
  std::atomic<bool> cancel = false;
  RunContext stopped(2);
  stopped.cancel = &cancel;
  struct StopAfterLevel : ProgressSink {
    void Report(double) override { *cancel = checkpoints->HasFinished("level_0"); }
    const CheckpointFolder* checkpoints;
    std::atomic<bool>* cancel;
  } sink;
  sink.checkpoints = &checkpoints;
  sink.cancel = &cancel;
  stopped.set_progress(&sink);
  EXPECT_THROW(RefineMesh(scene.s.scene, *scene.images, noisy, FastOptions(), stopped, checkpoints),
               CancelledError);
  for (const size_t num_found : {1u, 3u}) {
    const auto rest =
        RefineMesh(scene.s.scene, *scene.images, noisy, FastOptions(), RunContext(1), checkpoints);
    EXPECT_EQ(rest.num_steps_found, num_found);
    EXPECT_EQ(rest.mesh.vertices, whole.mesh.vertices);
    EXPECT_EQ(rest.mesh.faces, whole.mesh.faces);
    EXPECT_EQ(rest.mesh.vertex_quality, whole.mesh.vertex_quality);
    EXPECT_EQ(rest.message, whole.message);
  }
}

TEST(MeshRefiner, SaysWhyItCannotRefine) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 6, 64, 48));
  TriangleMesh hidden = scene.s.shape->Mesh(0.5);
  for (auto& x : hidden.vertices) x += Eigen::Vector3d(1000, 0, 0);
  const auto far = RefineMesh(scene.s.scene, *scene.images, hidden, FastOptions(), RunContext(1));
  EXPECT_EQ(far.status, RefinementStatus::kUnchanged);
  EXPECT_EQ(far.mesh.vertices, hidden.vertices);
  EXPECT_FALSE(far.message.empty());
  const auto empty = RefineMesh(scene.s.scene, *scene.images, {}, FastOptions(), RunContext(1));
  EXPECT_EQ(empty.status, RefinementStatus::kUnchanged);
}

TEST(MeshRefiner, SplitsWhatThePhotosResolveAndNothingElse) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 24, 128, 96));
  const TriangleMesh coarse = scene.s.shape->Mesh(30 * scene.s.gsd);
  MeshRefinerOptions options = FastOptions();
  const auto fine = RefineMesh(scene.s.scene, *scene.images, coarse, options, RunContext(2));
  ExpectValidClosedMesh(fine.mesh);
  EXPECT_GT(fine.num_splits, 0u);
  EXPECT_GT(fine.mesh.faces.size(), 2 * coarse.faces.size());
  EXPECT_LT(MeanErrorPx(scene.s, fine.mesh), 0.3);
  options.max_face_area_px = 0;
  options.improve_mesh = false;
  const auto same = RefineMesh(scene.s.scene, *scene.images, coarse, options, RunContext(2));
  EXPECT_EQ(same.mesh.faces, coarse.faces);
}

TEST(MeshRefiner, SimplifiesWithinTheToleranceAndColoursAfterwards) {
  const RenderedScene scene(MakeScene(ShapeName::kSphere, 24, 128, 96));
  const TriangleMesh input = scene.s.shape->Mesh(3 * scene.s.gsd);
  MeshRefinerOptions options = FastOptions();
  options.color_vertices = true;
  const auto all = RefineMesh(scene.s.scene, *scene.images, input, options, RunContext(2));
  size_t last = all.mesh.faces.size();
  for (const double tolerance : {0.1, 0.5}) {
    options.simplify_tolerance = tolerance;
    const auto few = RefineMesh(scene.s.scene, *scene.images, input, options, RunContext(2));
    ExpectValidClosedMesh(few.mesh);
    EXPECT_EQ(few.num_faces_refined, all.mesh.faces.size());
    EXPECT_LT(few.mesh.faces.size(), last);
    EXPECT_EQ(few.mesh.vertex_colors.size(), few.mesh.vertices.size());
    // Pixels are no larger than a GSD where a photo looks straight on; the sphere's far parts are
    // seen by other photos.
    EXPECT_LT(MeanErrorPx(scene.s, few.mesh), MeanErrorPx(scene.s, all.mesh) + tolerance);
    last = few.mesh.faces.size();
  }
}

TEST(MeshRefinerOptions, DefaultsAreValidAndBoundsAreNamed) {
  std::string error;
  EXPECT_TRUE(MeshRefinerOptions().Check(&error)) << error;
  const auto violates = [&](auto change, const std::string& name) {
    MeshRefinerOptions options;
    change(&options);
    error.clear();
    EXPECT_FALSE(options.Check(&error)) << name;
    EXPECT_NE(error.find(name), std::string::npos) << error;
  };
  violates([](auto* o) { o->num_levels = 0; }, "num_levels");
  violates([](auto* o) { o->max_num_iterations = -1; }, "max_num_iterations");
  violates([](auto* o) { o->window_radius = 8; }, "window_radius");
  violates([](auto* o) { o->max_num_neighbors = 17; }, "max_num_neighbors");
  violates([](auto* o) { o->max_pairs_per_face = 0; }, "max_pairs_per_face");
  violates([](auto* o) { o->smoothness = -1; }, "smoothness");
  violates([](auto* o) { o->membrane = -1; }, "membrane");
  violates([](auto* o) { o->noise_gray_levels = 300; }, "noise");
  violates([](auto* o) { o->depth_tolerance = 0; }, "depth_tolerance");
  violates([](auto* o) { o->max_step_px = 0; }, "max_step");
  violates([](auto* o) { o->min_relative_gain = 2; }, "min_relative_gain");
  violates([](auto* o) { o->max_face_area_px = -1; }, "max_face_area");
  violates([](auto* o) { o->simplify_tolerance = -1; }, "simplify_tolerance");
  violates([](auto* o) { o->hold_out_every = -1; }, "hold_out_every");
}

}  // namespace
}  // namespace lsmvs
