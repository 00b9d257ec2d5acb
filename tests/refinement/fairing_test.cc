#include "lsmvs/refinement/fairing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lsmvs/mesh/face_crossings.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

const RunContext kContext(2);

double Highest(const TriangleMesh& mesh) {
  double highest = 0;
  for (const Eigen::Vector3d& x : mesh.vertices) highest = std::max(highest, std::abs(x.z()));
  return highest;
}

TEST(SmoothCrumbs, PitsAndSpikesOfAPlaneGo) {
  constexpr int kSide = 40;
  TriangleMesh mesh = GridMesh(kSide);
  for (const int v : {10 * kSide + 10, 10 * kSide + 25, 25 * kSide + 12, 30 * kSide + 30}) {
    mesh.vertices[v].z() = v % 2 == 0 ? 4 : -6;
  }
  const TriangleMesh input = mesh;
  EXPECT_GT(SmoothCrumbs({}, &mesh, kContext), 4u);
  EXPECT_LT(Highest(mesh), 0.7);
  // What is not near a crumb stays to the bit.
  for (int v = 0; v < kSide; ++v) EXPECT_EQ(mesh.vertices[v], input.vertices[v]);
  EXPECT_EQ(mesh.vertices[18 * kSide + 35], input.vertices[18 * kSide + 35]);
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  EXPECT_TRUE(FaceGrid(mesh.vertices, mesh.faces).CrossingPairs(all, kContext).empty());
}

// A right-angled fold, a step and its sides are shape, not noise.
TEST(SmoothCrumbs, EdgesStay) {
  TriangleMesh fold = GridMesh(30);
  for (Eigen::Vector3d& x : fold.vertices) x.z() = std::abs(x.x() - 15);
  TriangleMesh step = GridMesh(30);
  for (Eigen::Vector3d& x : step.vertices) x.z() = x.x() < 15 ? 0 : 5;
  for (TriangleMesh* mesh : {&fold, &step}) {
    const std::vector<Eigen::Vector3d> before = mesh->vertices;
    EXPECT_EQ(SmoothCrumbs({}, mesh, kContext), 0u);
    EXPECT_EQ(mesh->vertices, before);
  }
}

TEST(SmoothCrumbs, ThreadsDoNotMatter) {
  TriangleMesh one = GridMesh(50);
  for (size_t v = 0; v < one.vertices.size(); v += 37) one.vertices[v].z() = 3;
  TriangleMesh three = one;
  SmoothCrumbs({}, &one, RunContext(1));
  SmoothCrumbs({}, &three, RunContext(3));
  EXPECT_EQ(one.vertices, three.vertices);
}

}  // namespace
}  // namespace lsmvs
