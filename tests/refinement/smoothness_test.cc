#include "lsmvs/refinement/step/smoothness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "lsmvs/refinement/step/step_solver.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

// A bumpy height field of n x n vertices.
TriangleMesh Bumps(int n, double spacing, double height, unsigned seed) {
  TriangleMesh mesh = GridMesh(n, spacing);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, height);
  for (Eigen::Vector3d& x : mesh.vertices) x.z() = normal(random);
  return mesh;
}

std::vector<Eigen::Vector3d> Up(const TriangleMesh& mesh) {
  return std::vector<Eigen::Vector3d>(mesh.vertices.size(), Eigen::Vector3d(0, 0, 1));
}

double Energy(const Smoothness& smoothness) {
  const std::vector<double> energies = smoothness.Energies();
  return std::accumulate(energies.begin(), energies.end(), 0.0);
}

class SmoothnessWeights : public testing::TestWithParam<LaplacianWeights> {};

TEST_P(SmoothnessWeights, GradientAgreesWithFiniteDifferences) {
  const RunContext context(1);
  // So low that the lengths of the edges, which the linearisation keeps, do not change.
  const TriangleMesh mesh = Bumps(7, 3.0, 1e-3, 1);
  const std::vector<double> pixel_size(mesh.vertices.size(), 1.0);
  Smoothness smoothness(mesh, {0.3, 0.0, GetParam()});
  smoothness.SetGeometry(mesh.vertices, Up(mesh), pixel_size, context);
  const std::vector<double> gradient = smoothness.Gradient(context);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto energy_at = [&](double t) {
      auto moved = mesh.vertices;
      moved[v].z() += t;
      smoothness.SetGeometry(moved, Up(mesh), pixel_size, context);
      return Energy(smoothness);
    };
    const double numeric = (energy_at(1e-4) - energy_at(-1e-4)) / 2e-4;
    EXPECT_NEAR(gradient[v], numeric, 1e-4 * std::abs(numeric) + 1e-7);
  }
}

TEST_P(SmoothnessWeights, HessianIsSymmetricAndPositive) {
  const RunContext context(1);
  const TriangleMesh mesh = Bumps(6, 2.0, 0.5, 2);
  const size_t count = mesh.vertices.size();
  std::vector<double> pixel_size(count);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0.8, 1.2);
  for (double& size : pixel_size) size = uniform(random);
  Smoothness smoothness(mesh, {1.0, 0.2, GetParam()});
  smoothness.SetGeometry(mesh.vertices, Up(mesh), pixel_size, context);
  std::vector<std::vector<double>> columns(count);
  std::vector<double> scratch;
  for (size_t v = 0; v < count; ++v) {
    std::vector<double> x(count, 0.0);
    x[v] = 1;
    smoothness.ApplyHessian(x, context, &scratch, &columns[v]);
  }
  const std::vector<double> diagonal = smoothness.HessianDiagonal();
  for (size_t v = 0; v < count; ++v) {
    EXPECT_NEAR(diagonal[v], columns[v][v], 1e-4 * diagonal[v]);
    EXPECT_GT(diagonal[v], 0);
    for (size_t w = 0; w < v; ++w) EXPECT_NEAR(columns[v][w], columns[w][v], 1e-4 * diagonal[v]);
  }
}

INSTANTIATE_TEST_SUITE_P(Weights, SmoothnessWeights,
                         testing::Values(LaplacianWeights::kUniform, LaplacianWeights::kCotangent));

TEST(Smoothness, PlanesAreFreeOfEnergyAndParaboloidsHaveTheIntegralOfTheirLaplacian) {
  const RunContext context(1);
  TriangleMesh mesh = Bumps(30, 1.5, 0.0, 1);
  const std::vector<double> pixel_size(mesh.vertices.size(), 1.0);
  Smoothness smoothness(mesh, {1.0, 0.0, LaplacianWeights::kCotangent});
  for (auto& x : mesh.vertices) x.z() = 0.1 * x.x() - 0.2 * x.y();
  smoothness.SetGeometry(mesh.vertices, Up(mesh), pixel_size, context);
  EXPECT_NEAR(Energy(smoothness), 0, 1e-9);
  const double curvature = 1e-3;
  for (auto& x : mesh.vertices) x.z() = curvature * (x.x() * x.x() + x.y() * x.y());
  smoothness.SetGeometry(mesh.vertices, Up(mesh), pixel_size, context);
  // Laplacian 4 c over 28 x 28 inner cells. Right angles instead of equilateral triangles: within a
  // factor of 1.6.
  const double area = 28 * 28 * 1.5 * 1.5, expected = 16 * curvature * curvature * area;
  EXPECT_GT(Energy(smoothness), expected / 1.6);
  EXPECT_LT(Energy(smoothness), expected * 1.6);
}

TEST(Smoothness, DoesNotDependOnTheUnitNorMuchOnTheSizeOfTriangles) {
  const RunContext context(1);
  const auto energy = [&](int n, double spacing, double unit) {
    TriangleMesh mesh = Bumps(n, spacing, 0.0, 1);
    for (auto& x : mesh.vertices) {
      x.z() = std::sin(0.2 * x.x()) * std::cos(0.15 * x.y());
      x *= unit;
    }
    Smoothness smoothness(mesh, {1.0, 0.0, LaplacianWeights::kUniform});
    smoothness.SetGeometry(mesh.vertices, Up(mesh), std::vector<double>(mesh.vertices.size(), unit),
                           context);
    return Energy(smoothness);
  };
  const double base = energy(41, 2.0, 1.0);
  EXPECT_NEAR(energy(41, 2.0, 1e-4), base, 1e-6 * base);
  EXPECT_NEAR(energy(81, 1.0, 1.0), base, 0.15 * base);
}

TEST(StepSolver, SolvesWhatItSaysAndKeepsFixedVertices) {
  const RunContext context(1);
  const TriangleMesh mesh = Bumps(8, 3.0, 0.3, 5);
  const size_t count = mesh.vertices.size();
  Smoothness smoothness(mesh, {1.0, 0.0, LaplacianWeights::kUniform});
  smoothness.SetGeometry(mesh.vertices, Up(mesh), std::vector<double>(count, 1.0), context);
  const std::vector<double> gradient = smoothness.Gradient(context), diagonal(count, 0.1);
  std::vector<uint8_t> fixed(count, 0);
  fixed[9] = fixed[30] = 1;
  const StepSolution solution =
      SolveStep(smoothness, diagonal, gradient, fixed, 1000, 1e-10, context);
  std::vector<double> scratch, product;
  smoothness.ApplyHessian(solution.x, context, &scratch, &product);
  for (size_t v = 0; v < count; ++v) {
    if (fixed[v]) {
      EXPECT_EQ(solution.x[v], 0);
    } else {
      EXPECT_NEAR(product[v] + diagonal[v] * solution.x[v], -gradient[v], 1e-5);
    }
  }
}

TEST(VertexRings, ListNeighborsInOrderAndKnowTheBorder) {
  const TriangleMesh mesh = Bumps(4, 1.0, 0.0, 1);
  const VertexRings rings = BuildVertexRings(mesh);
  int num_border = 0;
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto first = rings.neighbors.begin() + rings.begin[v];
    const auto last = rings.neighbors.begin() + rings.begin[v + 1];
    EXPECT_TRUE(std::is_sorted(first, last));
    num_border += rings.on_border[v];
  }
  EXPECT_EQ(num_border, 12);
  EXPECT_EQ(rings.begin[6] - rings.begin[5], 6);
}

}  // namespace
}  // namespace lsmvs
