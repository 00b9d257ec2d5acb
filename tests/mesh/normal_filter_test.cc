#include "lsmvs/mesh/normal_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simple_meshes.h"

namespace lsmvs {
namespace {

constexpr int kSquares = 60;
constexpr double kEdge = 1.0 / kSquares;

// A fold of two planes that meet at x = 1/2 with a right angle, as the height of the roof.
double Roof(double x) { return 0.5 - std::abs(x - 0.5); }

// `noise` in edge lengths of the plan.
TriangleMesh NoisyRoof(double noise) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, noise * kEdge);
  return UnitSquareMesh(kSquares, [&](double x, double y) {
    return Eigen::Vector3d(x, y, Roof(x) + normal(random));
  });
}

bool Inside(const Eigen::Vector3d& x) {
  return std::min({x[0], x[1], 1 - x[0], 1 - x[1]}) > 5 * kEdge;
}

// RMS distance from the roof's planes, in edge lengths, where `counts`.
template <class Counts>
double Roughness(const TriangleMesh& mesh, const Counts& counts) {
  double sum = 0;
  int count = 0;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    if (!Inside(x) || !counts(x)) continue;
    sum += 0.5 * std::pow((x[2] - Roof(x[0])) / kEdge, 2);
    ++count;
  }
  return std::sqrt(sum / count);
}

// Mean angle (degrees) of the normals with the roof's.
double NormalError(const TriangleMesh& mesh) {
  double sum = 0;
  int count = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3d& x = mesh.vertices[static_cast<size_t>(mesh.faces[f][0])];
    if (!Inside(x) || std::abs(x[0] - 0.5) < 2 * kEdge) continue;
    const Eigen::Vector3d truth = Eigen::Vector3d(x[0] < 0.5 ? -1 : 1, 0, 1).normalized();
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, f).normalized();
    sum += std::acos(std::clamp(normal.dot(truth), -1.0, 1.0)) * 180 / M_PI;
    ++count;
  }
  return sum / count;
}

TriangleMesh Filtered(TriangleMesh mesh, int num_passes, int num_threads = 1) {
  FilterNormals({.num_passes = num_passes}, ShortestEdges(mesh), RunContext(num_threads), &mesh);
  return mesh;
}

TEST(FilterNormals, TakesNoiseOffPlanesAndLeavesTheEdge) {
  const TriangleMesh noisy = NoisyRoof(0.2), filtered = Filtered(noisy, 3);
  const auto anywhere = [](const Eigen::Vector3d&) { return true; };
  const auto at_edge = [](const Eigen::Vector3d& x) { return std::abs(x[0] - 0.5) < 1.5 * kEdge; };
  EXPECT_LT(NormalError(filtered), 0.2 * NormalError(noisy));
  EXPECT_LT(Roughness(filtered, anywhere), 0.7 * Roughness(noisy, anywhere));
  // A filter that rounds the edge by one edge length would leave more than half of that there.
  EXPECT_LT(Roughness(filtered, at_edge), Roughness(noisy, at_edge));
}

TEST(FilterNormals, WhatHasNoNoiseStays) {
  const TriangleMesh roof = NoisyRoof(0), filtered = Filtered(roof, 2);
  for (size_t v = 0; v < roof.vertices.size(); ++v) {
    EXPECT_LT((filtered.vertices[v] - roof.vertices[v]).norm(), 0.02 * kEdge);
  }
  const TriangleMesh sphere = SphereMesh(5), filtered_sphere = Filtered(sphere, 2);
  // Edges are 0.05 long.
  for (const Eigen::Vector3d& x : filtered_sphere.vertices) EXPECT_NEAR(x.norm(), 1, 0.0015);
}

TEST(FilterNormals, SingleSpikesSink) {
  TriangleMesh mesh = NoisyRoof(0);
  const size_t spike = 20 * (kSquares + 1) + 12;
  const double height = mesh.vertices[spike][2];
  mesh.vertices[spike][2] += kEdge;
  EXPECT_NEAR(Filtered(mesh, 2).vertices[spike][2], height, 0.65 * kEdge);
}

TEST(FilterNormals, KeepsToTheLimitsAndTheBorder) {
  const TriangleMesh noisy = NoisyRoof(0.3);
  std::vector<double> limits(noisy.vertices.size());
  for (size_t v = 0; v < limits.size(); ++v) limits[v] = v % 3 == 0 ? 0.0 : 0.05 * kEdge;
  TriangleMesh filtered = noisy;
  FilterNormals({.num_passes = 2}, limits, RunContext(1), &filtered);
  size_t num_moved = 0;
  for (size_t v = 0; v < limits.size(); ++v) {
    const double way = (filtered.vertices[v] - noisy.vertices[v]).norm();
    EXPECT_LE(way, limits[v] * (1 + 1e-9));
    const size_t row = v / (kSquares + 1), column = v % (kSquares + 1);
    const bool on_border = row == 0 || column == 0 || row == kSquares || column == kSquares;
    if (on_border) {
      EXPECT_EQ(way, 0);
    }
    num_moved += way > 0;
  }
  EXPECT_GT(num_moved, limits.size() / 2);
}

TEST(FilterNormals, TheUnitAndTheThreadsDoNotMatter) {
  // Large enough for several blocks of vertices and faces.
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 0.002);
  const TriangleMesh mesh = UnitSquareMesh(
      150, [&](double x, double y) { return Eigen::Vector3d(x, y, normal(random)); });
  TriangleMesh large = mesh;
  for (Eigen::Vector3d& x : large.vertices) x *= 1024;
  const TriangleMesh one = Filtered(mesh, 2), two = Filtered(mesh, 2, 2);
  large = Filtered(large, 2);
  EXPECT_EQ(one.vertices, two.vertices);
  for (size_t v = 0; v < one.vertices.size(); ++v) {
    EXPECT_EQ(1024 * one.vertices[v], large.vertices[v]);
  }
}

TEST(FilterNormals, VerticesAtEdgesOfThreeFacesStay) {
  TriangleMesh mesh = NoisyRoof(0.3);
  const size_t a = 20 * (kSquares + 1) + 20;
  mesh.vertices.emplace_back(mesh.vertices[a] + Eigen::Vector3d(0, 0, kEdge));
  mesh.faces.emplace_back(static_cast<int>(a), static_cast<int>(a) + 1,
                          static_cast<int>(mesh.vertices.size()) - 1);
  const TriangleMesh filtered = Filtered(mesh, 2);
  EXPECT_EQ(filtered.vertices[a], mesh.vertices[a]);
  EXPECT_EQ(filtered.vertices[a + 1], mesh.vertices[a + 1]);
  EXPECT_NE(filtered.vertices[a + 2], mesh.vertices[a + 2]);
}

// Faces without area are no even patches.
TEST(FilterNormals, CollapsedFacesDoNotGuide) {
  TriangleMesh mesh = NoisyRoof(0.2);
  const size_t center = 20 * (kSquares + 1) + 20;
  for (const size_t row : {center - kSquares - 1, center, center + kSquares + 1}) {
    for (const size_t v : {row - 1, row, row + 1}) mesh.vertices[v] = mesh.vertices[center];
  }
  EXPECT_LT(NormalError(Filtered(mesh, 3)), 0.25 * NormalError(mesh));
}

TEST(FilterNormals, DegenerateAndEmptyMeshesAreLeft) {
  TriangleMesh empty;
  FilterNormals({}, {}, RunContext(1), &empty);
  EXPECT_TRUE(empty.empty());
  TriangleMesh flat = NoisyRoof(0);
  for (Eigen::Vector3d& x : flat.vertices) x = Eigen::Vector3d(1, 2, 3);
  const TriangleMesh filtered = Filtered(flat, 2);
  EXPECT_EQ(filtered.vertices, flat.vertices);
}

TEST(ShortestEdges, OfEachVertex) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}, {9, 9, 9}};
  mesh.faces = {{0, 1, 2}};
  const std::vector<double> lengths = ShortestEdges(mesh);
  EXPECT_EQ(lengths[0], 3);
  EXPECT_EQ(lengths[1], 3);
  EXPECT_EQ(lengths[2], 4);
  EXPECT_TRUE(std::isinf(lengths[3]));
}

}  // namespace
}  // namespace lsmvs
