#include "lsmvs/mesh/surface_trimming.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "lsmvs/mesh/repair.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

const RunContext kContext(2);

// Length of the border of the faces that are kept.
double BorderLength(const TriangleMesh& mesh, const std::vector<uint8_t>& kept) {
  std::map<std::pair<int, int>, int> num_faces;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int k = 0; kept[f] && k < 3; ++k) {
      ++num_faces[std::minmax(mesh.faces[f][k], mesh.faces[f][(k + 1) % 3])];
    }
  }
  double length = 0;
  for (const auto& [edge, count] : num_faces) {
    if (count == 1) length += (mesh.vertices[edge.first] - mesh.vertices[edge.second]).norm();
  }
  return length;
}

double Energy(const TriangleMesh& mesh, const TrimmingProblem& problem,
              const std::vector<uint8_t>& kept) {
  double energy = problem.border_cost * BorderLength(mesh, kept);
  for (size_t f = 0; f < kept.size(); ++f) energy += kept[f] ? 0.0 : problem.keep_gain[f];
  return energy;
}

TrimmingProblem ProblemOn(const TriangleMesh& mesh, double border_cost) {
  return {std::vector<double>(mesh.faces.size(), 0.5),
          std::vector<double>(mesh.vertices.size(), 1.0), border_cost};
}

// Against every labelling of 18 faces.
TEST(TrimSurface, FindsTheLeastEnergy) {
  const TriangleMesh mesh = GridMesh(4);
  ASSERT_EQ(mesh.faces.size(), 18u);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> gain(-3, 3);
  for (int trial = 0; trial < 5; ++trial) {
    TrimmingProblem problem = ProblemOn(mesh, 0.25 * trial);
    for (double& g : problem.keep_gain) g = std::round(16 * gain(random)) / 16;
    double least = std::numeric_limits<double>::infinity();
    std::vector<uint8_t> labels(mesh.faces.size());
    for (uint32_t bits = 0; bits < 1u << labels.size(); ++bits) {
      for (size_t f = 0; f < labels.size(); ++f) labels[f] = bits >> f & 1;
      least = std::min(least, Energy(mesh, problem, labels));
    }
    const std::vector<uint8_t> kept = TrimSurface(mesh, problem, kContext);
    // Only the lengths of the 9 diagonals are cut to sixteenths.
    EXPECT_LE(Energy(mesh, problem, kept), least + 9.0 / 16);
    EXPECT_GE(Energy(mesh, problem, kept), least);
  }
}

// A disc of radius r goes if its area is worth its circumference: where r / 2 is above the price of
// the border. What is left at prices a little above are the parts of
// the disc whose border along edges is shorter than the circle.
TEST(TrimSurface, AGapGoesWhereItsAreaOutweighsItsBorder) {
  const TriangleMesh mesh = GridMesh(81);
  constexpr double kRadius = 20;
  std::vector<uint8_t> inside(mesh.faces.size());
  for (size_t f = 0; f < inside.size(); ++f) {
    inside[f] = (FaceMiddle(mesh, f) - Eigen::Vector3d(40, 40, 0)).norm() < kRadius;
  }
  const auto dropped = [&](double border_cost) {
    TrimmingProblem problem = ProblemOn(mesh, border_cost);
    for (size_t f = 0; f < inside.size(); ++f) problem.keep_gain[f] = inside[f] ? -0.5 : 10.0;
    const std::vector<uint8_t> kept = TrimSurface(mesh, problem, kContext);
    return std::count(kept.begin(), kept.end(), 0);
  };
  const double area = std::numbers::pi * kRadius * kRadius;
  EXPECT_NEAR(static_cast<double>(dropped(0.3 * kRadius)), 2 * area, 0.06 * area);
  EXPECT_EQ(dropped(0.65 * kRadius), 0);
}

TEST(TrimSurface, BordersHaveNoTeeth) {
  const TriangleMesh mesh = GridMesh(41);
  TrimmingProblem problem = ProblemOn(mesh, 0);
  // The left half has evidence against it, with much noise at the edge of the evidence.
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 4);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    problem.keep_gain[f] = FaceMiddle(mesh, f).x() + noise(random) < 20 ? -0.5 : 0.5;
  }
  const double ragged = BorderLength(mesh, TrimSurface(mesh, problem, kContext));
  problem.border_cost = 4;
  const double clean = BorderLength(mesh, TrimSurface(mesh, problem, kContext));
  EXPECT_GT(ragged, 400);
  EXPECT_LT(clean, 1.1 * (20 + 20 + 40 + 40));
  EXPECT_GT(clean, 0.9 * (20 + 20 + 40 + 40));
}

TEST(KeepEnclosedFaces, OnlyPiecesAtTheBorderAndHiddenOnesGo) {
  const TriangleMesh mesh = GridMesh(11);
  std::vector<uint8_t> kept(mesh.faces.size(), 1);
  size_t num_inside = 0;
  for (size_t f = 0; f < kept.size(); ++f) {
    const Eigen::Vector3d x = FaceMiddle(mesh, f);
    const bool at_border = x.x() < 2, inside = (x - Eigen::Vector3d(6, 6, 0)).norm() < 2;
    kept[f] = !at_border && !inside;
    num_inside += inside;
  }
  std::vector<uint8_t> hidden = kept;
  EXPECT_EQ(KeepEnclosedFaces(mesh, std::vector<uint8_t>(kept.size(), 0), &hidden), 0u);
  EXPECT_EQ(hidden, kept);
  EXPECT_EQ(KeepEnclosedFaces(mesh, {}, &kept), num_inside);
  for (size_t f = 0; f < kept.size(); ++f) EXPECT_EQ(kept[f], FaceMiddle(mesh, f).x() >= 2);
}

}  // namespace
}  // namespace lsmvs
