#include "lsmvs/refinement/mesh_refiner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "lsmvs/test_support/temporary_folder.h"

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

MeshRefinerOptions FastOptions() {
  MeshRefinerOptions options;
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

}  // namespace
}  // namespace lsmvs
