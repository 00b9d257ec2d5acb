#include "lsmvs/mesh/remesher.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

// An octahedron whose faces are split `levels` times, on the unit sphere.
TriangleMesh Sphere(int levels) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const double area = 4 * M_PI / 8;
  Remesher remesher(mesh, mesh.vertices, std::vector<float>(8, 1.0f));
  remesher.SplitLargeFaces(area / std::pow(4, levels), 20);
  mesh = remesher.Mesh();
  for (auto& x : mesh.vertices) x.normalize();
  return mesh;
}

std::vector<float> Density(const TriangleMesh& mesh, float value) {
  return std::vector<float>(mesh.faces.size(), value);
}

double LargestFace(const TriangleMesh& mesh) {
  double largest = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    largest = std::max(largest, 0.5 * FaceNormalTimesTwiceArea(mesh, f).norm());
  }
  return largest;
}

TEST(Remesher, SplitsUntilNoFaceIsLargeAndKeepsTheSurface) {
  const TriangleMesh grid = GridMesh(6);
  Remesher remesher(grid, grid.vertices, Density(grid, 4.0f));
  EXPECT_GT(remesher.SplitLargeFaces(0.5, 20), 0u);
  const TriangleMesh mesh = remesher.Mesh();
  ExpectValidMesh(mesh);
  EXPECT_LE(LargestFace(mesh), 0.5 / 4.0 + 1e-12);
  EXPECT_NEAR(Inspect(mesh).area, 25, 1e-9);
  EXPECT_EQ(mesh.vertices, remesher.Rest());
}

TEST(Remesher, NeverSplitsWhatHasNoDensity) {
  const TriangleMesh grid = GridMesh(5);
  Remesher remesher(grid, grid.vertices, Density(grid, 0.0f));
  EXPECT_EQ(remesher.SplitLargeFaces(1e-6), 0u);
  EXPECT_EQ(remesher.CollapseShortEdges(10, 10), 0u);
  EXPECT_EQ(remesher.Mesh().faces, grid.faces);
}

TEST(Remesher, CollapsesOfAPlaneKeepItsAreaAndBorder) {
  const TriangleMesh grid = GridMesh(12);
  Remesher remesher(grid, grid.vertices, Density(grid, 1.0f));
  EXPECT_GT(remesher.CollapseShortEdges(1.2, 0.01), 20u);
  const TriangleMesh mesh = remesher.Mesh();
  ExpectValidMesh(mesh);
  EXPECT_NEAR(Inspect(mesh).area, 121, 1e-9);
  EXPECT_EQ(Inspect(mesh).num_border_edges, Inspect(grid).num_border_edges);
}

TEST(Remesher, EverythingTogetherKeepsASphereClosedAndInPlace) {
  TriangleMesh sphere = Sphere(4);
  ExpectValidClosedMesh(sphere);
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.01);
  for (auto& x : sphere.vertices) {
    x += Eigen::Vector3d(noise(random), noise(random), noise(random));
    x.normalize();
  }
  Remesher remesher(sphere, sphere.vertices, Density(sphere, 1.0f));
  EXPECT_GT(remesher.CollapseShortEdges(0.08, 0.01), 0u);
  remesher.SplitLargeFaces(0.003);
  EXPECT_GT(remesher.FlipToDelaunay(0.01), 0u);
  const TriangleMesh mesh = remesher.Mesh();
  ExpectValidClosedMesh(mesh);
  EXPECT_EQ(Inspect(mesh).Genus(), 0);
  for (const auto& x : mesh.vertices) EXPECT_NEAR(x.norm(), 1, 0.03);
  EXPECT_EQ(mesh.vertices, remesher.Rest());
}

TEST(Remesher, FlipsALongDiagonal) {
  TriangleMesh mesh = GridMesh(5);
  // Squeezes one inner quadrilateral so that its diagonal is the long one.
  mesh.vertices[2 * 5 + 1] += Eigen::Vector3d(-0.3, 0.3, 0);
  mesh.vertices[1 * 5 + 2] += Eigen::Vector3d(0.3, -0.3, 0);
  Remesher remesher(mesh, mesh.vertices, Density(mesh, 1.0f));
  EXPECT_GT(remesher.FlipToDelaunay(0.1), 0u);
  ExpectValidMesh(remesher.Mesh());
  EXPECT_NEAR(Inspect(remesher.Mesh()).area, 16, 1e-9);
}

TEST(Remesher, LeavesNonManifoldPartsAsTheyAre) {
  TriangleMesh mesh = GridMesh(4);
  // A fin on an inner edge.
  mesh.vertices.push_back({1.5, 1, 1});
  mesh.faces.push_back({5, 6, 16});
  const size_t before = Inspect(mesh).num_nonmanifold_edges;
  Remesher remesher(mesh, mesh.vertices, Density(mesh, 1.0f));
  remesher.CollapseShortEdges(1.1, 1);
  remesher.SplitLargeFaces(0.3);
  remesher.FlipToDelaunay(1);
  const TriangleMesh result = remesher.Mesh();
  EXPECT_EQ(Inspect(result).num_nonmanifold_edges, before);
  EXPECT_EQ(Inspect(result).num_duplicate_faces, 0u);
}

// Two faces back to back are a closed manifold of their own; split halves would share an edge four
// times over.
TEST(Remesher, KeepsFacesBackToBackManifold) {
  TriangleMesh mesh = GridMesh(4);
  mesh.vertices.insert(mesh.vertices.end(), {{0, 0, 2}, {3, 0, 2}, {0, 3, 2}});
  mesh.faces.push_back({16, 17, 18});
  mesh.faces.push_back({17, 16, 18});
  const MeshInspection before = Inspect(mesh);
  ASSERT_TRUE(before.IsManifold());
  Remesher remesher(mesh, mesh.vertices, Density(mesh, 1.0f));
  EXPECT_GT(remesher.SplitLargeFaces(0.1), 0u);
  remesher.FlipToDelaunay(1);
  remesher.CollapseShortEdges(0.5, 1);
  const MeshInspection after = Inspect(remesher.Mesh());
  EXPECT_TRUE(after.IsManifold());
  EXPECT_TRUE(after.IsOriented());
  EXPECT_EQ(after.euler_characteristic, before.euler_characteristic);
  EXPECT_EQ(after.num_components, before.num_components);
}

}  // namespace
}  // namespace lsmvs
