#include "lsmvs/mesh/smoothing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lsmvs/mesh/inspect.h"
#include "simple_meshes.h"

namespace lsmvs {
namespace {

TriangleMesh NoisySphere(double noise) {
  TriangleMesh mesh = SphereMesh(4);
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, noise);
  for (Eigen::Vector3d& x : mesh.vertices) x *= 1 + normal(random);
  return mesh;
}

double Roughness(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3d& x : mesh.vertices) sum += std::pow(x.norm() - 1, 2);
  return std::sqrt(sum / static_cast<double>(mesh.vertices.size()));
}

TEST(SmoothTaubin, TakesNoiseAndLeavesTheVolume) {
  TriangleMesh mesh = NoisySphere(0.01);
  const double roughness = Roughness(mesh), volume = Inspect(mesh).volume;
  SmoothTaubin({.num_iterations = 5}, RunContext(1), &mesh);
  EXPECT_LT(Roughness(mesh), 0.5 * roughness);
  EXPECT_NEAR(Inspect(mesh).volume, volume, 0.005 * volume);
}

TEST(SmoothTaubin, BorderStays) {
  TriangleMesh mesh = NoisySphere(0.01);
  mesh.faces.resize(mesh.faces.size() / 2);
  const TriangleMesh before = mesh;
  SmoothTaubin({.num_iterations = 2}, RunContext(1), &mesh);
  std::vector<int> balance(mesh.vertices.size(), 0);
  for (const auto& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) balance[face[k]] += face[(k + 1) % 3] - face[(k + 2) % 3];
  }
  size_t num_border = 0;
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (balance[v] == 0) continue;
    ++num_border;
    EXPECT_EQ(mesh.vertices[v], before.vertices[v]);
  }
  EXPECT_GT(num_border, 10u);
}

TEST(SmoothTaubin, TheUnitAndTheThreadsDoNotMatter) {
  const TriangleMesh mesh = NoisySphere(0.02);
  TriangleMesh one = mesh, two = mesh, large = mesh;
  for (Eigen::Vector3d& x : large.vertices) x *= 1024;
  SmoothTaubin({}, RunContext(1), &one);
  SmoothTaubin({}, RunContext(2), &two);
  SmoothTaubin({}, RunContext(1), &large);
  EXPECT_EQ(one.vertices, two.vertices);
  for (size_t v = 0; v < one.vertices.size(); ++v) {
    EXPECT_EQ(1024 * one.vertices[v], large.vertices[v]);
  }
}

TEST(SmoothTaubin, NoStepsChangeNothing) {
  const TriangleMesh mesh = NoisySphere(0.02);
  TriangleMesh same = mesh;
  SmoothTaubin({.num_iterations = 0}, RunContext(1), &same);
  EXPECT_EQ(same.vertices, mesh.vertices);
}

}  // namespace
}  // namespace lsmvs
