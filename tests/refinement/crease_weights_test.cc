#include "lsmvs/refinement/step/crease_weights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lsmvs/refinement/step/smoothness.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

constexpr int kSide = 41, kFacesPerRegion = 256;
constexpr double kStiffness = 30.0, kSpacing = 2.0;

// Two planes that meet in a right angle along the middle column, with noise in height.
TriangleMesh Roof(double noise, double unit) {
  TriangleMesh mesh = GridMesh(kSide, kSpacing);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, noise);
  double ridge = 0;
  for (const Eigen::Vector3d& x : mesh.vertices)
    ridge += x.x() / static_cast<double>(mesh.vertices.size());
  for (Eigen::Vector3d& x : mesh.vertices) {
    x.z() = -std::abs(x.x() - ridge) + normal(random);
    x *= unit;
  }
  return mesh;
}

std::vector<float> FactorsOf(const TriangleMesh& mesh, double pixel_size, int threads = 1) {
  const RunContext context(threads);
  Smoothness plate(mesh, {});
  plate.SetGeometry(mesh.vertices,
                    std::vector<Eigen::Vector3d>(mesh.vertices.size(), Eigen::Vector3d(0, 0, 1)),
                    std::vector<double>(mesh.vertices.size(), pixel_size), context);
  const CreaseWeights weights(mesh, GrowFaceRegions(mesh, kFacesPerRegion), kStiffness);
  return weights.Factors(plate.SquaredLaplacians(), plate.rings(), context);
}

// Mean factor of the vertices that lie so many columns from the ridge.
double MeanAt(const TriangleMesh& mesh, const std::vector<float>& factors, double from, double to) {
  double ridge = 0, sum = 0;
  int count = 0;
  for (const Eigen::Vector3d& x : mesh.vertices)
    ridge += x.x() / static_cast<double>(mesh.vertices.size());
  for (size_t v = 0; v < factors.size(); ++v) {
    const double columns = std::abs(mesh.vertices[v].x() - ridge) / kSpacing;
    if (columns < from || columns > to) continue;
    sum += static_cast<double>(factors[v]);
    ++count;
  }
  return sum / count;
}

TEST(CreaseWeights, AreSoftAtTheCreaseAndStiffOnNoise) {
  const TriangleMesh mesh = Roof(0.05, 1.0);
  const std::vector<float> factors = FactorsOf(mesh, 1.0);
  EXPECT_LT(MeanAt(mesh, factors, 0, 0.5), 1.1);
  EXPECT_GT(MeanAt(mesh, factors, 3, 20), 5.0);
  for (const float factor : factors) {
    EXPECT_GE(factor, 1.0f);
    EXPECT_LE(factor, static_cast<float>(kStiffness));
  }
}

// The usual bend is what the surface itself shows: more noise everywhere makes no creases.
TEST(CreaseWeights, DoNotDependOnUnitsOrTheSizeOfTheNoise) {
  const TriangleMesh flat = Roof(0.0, 1.0);
  std::vector<float> of_noise[2];
  for (int k = 0; k < 2; ++k) {
    TriangleMesh mesh = Roof(k == 0 ? 0.01 : 0.1, 1.0);
    for (size_t v = 0; v < mesh.vertices.size(); ++v) mesh.vertices[v].z() -= flat.vertices[v].z();
    of_noise[k] = FactorsOf(mesh, 1.0);
  }
  const TriangleMesh mesh = Roof(0.05, 1.0), larger = Roof(0.05, 1000.0);
  const std::vector<float> one = FactorsOf(mesh, 1.0), other = FactorsOf(larger, 1000.0);
  for (size_t v = 0; v < one.size(); ++v) {
    EXPECT_NEAR(of_noise[0][v], of_noise[1][v], 0.02 * kStiffness);
    EXPECT_NEAR(one[v], other[v], 1e-3 * kStiffness);
  }
}

TEST(CreaseWeights, APlaneIsFlatAndThreadsChangeNothing) {
  TriangleMesh plane = GridMesh(kSide, kSpacing);
  for (const float factor : FactorsOf(plane, 1.0)) {
    EXPECT_EQ(factor, static_cast<float>(kStiffness));
  }
  const TriangleMesh mesh = Roof(0.05, 1.0);
  EXPECT_EQ(FactorsOf(mesh, 1.0, 1), FactorsOf(mesh, 1.0, 3));
}

TEST(CreaseWeights, VerticesWithoutFacesHaveFactorOne) {
  TriangleMesh mesh = GridMesh(kSide, kSpacing);
  mesh.vertices.emplace_back(1, 2, 3);
  EXPECT_EQ(FactorsOf(mesh, 1.0).back(), 1.0f);
}

}  // namespace
}  // namespace lsmvs
