#include "lsmvs/mesh/inspect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "lsmvs/synthetic/analytic_shapes.h"

namespace lsmvs {
namespace {

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

// Adds a copy whose vertices are new, but for those listed in `shared` (which keep their index).
void AddCopy(const TriangleMesh& piece, const std::vector<int>& shared, TriangleMesh* mesh) {
  std::vector<int> index;
  for (int v = 0; v < static_cast<int>(piece.vertices.size()); ++v) {
    if (std::find(shared.begin(), shared.end(), v) != shared.end()) {
      index.push_back(v);
    } else {
      index.push_back(static_cast<int>(mesh->vertices.size()));
      mesh->vertices.push_back(-piece.vertices[v]);
    }
  }
  // Mirrored at the origin: turn the faces round.
  for (const Eigen::Vector3i& f : piece.faces) {
    mesh->faces.emplace_back(index[f[0]], index[f[2]], index[f[1]]);
  }
}

TEST(Inspect, TetrahedronIsPerfect) {
  const MeshInspection i = Inspect(Tetrahedron());
  EXPECT_EQ(i.num_vertices, 4u);
  EXPECT_EQ(i.num_faces, 4u);
  EXPECT_EQ(i.num_edges, 6u);
  EXPECT_TRUE(i.IsManifold() && i.IsOriented() && i.IsClosed());
  EXPECT_EQ(i.num_components, 1u);
  EXPECT_EQ(i.euler_characteristic, 2);
  EXPECT_EQ(i.Genus(), 0);
  EXPECT_NEAR(i.volume, 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(i.area, 1.5 + std::sqrt(3.0) / 2, 1e-15);
  EXPECT_EQ(i.num_degenerate_faces + i.num_duplicate_faces + i.num_unused_vertices, 0u);
}

TEST(Inspect, VolumeIsNegativeInsideOutAndInvariantToTranslation) {
  TriangleMesh mesh = Tetrahedron();
  for (Eigen::Vector3d& x : mesh.vertices) x += Eigen::Vector3d(1e6, -2e6, 3e6);
  EXPECT_NEAR(Inspect(mesh).volume, 1.0 / 6.0, 1e-8);
  for (Eigen::Vector3i& f : mesh.faces) std::swap(f[0], f[1]);
  EXPECT_NEAR(Inspect(mesh).volume, -1.0 / 6.0, 1e-8);
  EXPECT_TRUE(Inspect(mesh).IsOriented());
}

TEST(Inspect, MissingFaceLeavesABorder) {
  TriangleMesh mesh = Tetrahedron();
  mesh.faces.pop_back();
  const MeshInspection i = Inspect(mesh);
  EXPECT_EQ(i.num_border_edges, 3u);
  EXPECT_FALSE(i.IsClosed());
  EXPECT_TRUE(i.IsManifold() && i.IsOriented());
}

TEST(Inspect, TurnedFaceIsMisorientedAtItsThreeEdges) {
  TriangleMesh mesh = Tetrahedron();
  std::swap(mesh.faces[0][0], mesh.faces[0][1]);
  const MeshInspection i = Inspect(mesh);
  EXPECT_EQ(i.num_misoriented_edges, 3u);
  EXPECT_FALSE(i.IsOriented());
  EXPECT_TRUE(i.IsManifold());
}

TEST(Inspect, BodiesThatTouchInAVertex) {
  TriangleMesh mesh = Tetrahedron();
  AddCopy(Tetrahedron(), {0}, &mesh);
  const MeshInspection i = Inspect(mesh);
  EXPECT_EQ(i.num_nonmanifold_vertices, 1u);
  EXPECT_EQ(i.num_nonmanifold_edges, 0u);
  EXPECT_FALSE(i.IsManifold());
  EXPECT_EQ(i.num_components, 1u);
  EXPECT_TRUE(i.IsClosed());
}

TEST(Inspect, BodiesThatTouchInAnEdge) {
  TriangleMesh mesh = Tetrahedron();
  AddCopy(Tetrahedron(), {0, 1}, &mesh);
  const MeshInspection i = Inspect(mesh);
  EXPECT_EQ(i.num_nonmanifold_edges, 1u);
  EXPECT_FALSE(i.IsManifold() || i.IsClosed() || i.IsOriented());
}

TEST(Inspect, SeparateBodiesAreComponents) {
  TriangleMesh mesh = Tetrahedron();
  AddCopy(Tetrahedron(), {}, &mesh);
  const MeshInspection i = Inspect(mesh);
  EXPECT_EQ(i.num_components, 2u);
  EXPECT_EQ(i.euler_characteristic, 4);
  EXPECT_TRUE(i.IsManifold());
}

TEST(Inspect, DegenerateDuplicateAndUnused) {
  TriangleMesh mesh = Tetrahedron();
  mesh.vertices.emplace_back(5, 5, 5);
  EXPECT_EQ(Inspect(mesh).num_unused_vertices, 1u);
  EXPECT_EQ(Inspect(mesh).euler_characteristic, 2);
  mesh.faces.emplace_back(0, 1, 0);
  EXPECT_EQ(Inspect(mesh).num_degenerate_faces, 1u);
  mesh.faces.back() = {2, 1, 0};  // the first face, turned round
  EXPECT_EQ(Inspect(mesh).num_duplicate_faces, 1u);
  EXPECT_EQ(Inspect(mesh).num_nonmanifold_edges, 3u);
  mesh = Tetrahedron();
  mesh.vertices.emplace_back(0.5, 0.5, 0);
  mesh.vertices.emplace_back(1, 0, 0);
  mesh.faces.emplace_back(1, 4, 5);  // three corners, no area
  EXPECT_EQ(Inspect(mesh).num_degenerate_faces, 1u);
}

TEST(Inspect, MoebiusStripCannotBeOriented) {
  TriangleMesh mesh;
  constexpr int kSteps = 12;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSteps, half = angle / 2;
    for (const double w : {-0.3, 0.3}) {
      const double r = 1 + w * std::cos(half);
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), w * std::sin(half));
    }
  }
  for (int i = 0; i < kSteps; ++i) {
    const bool last = i + 1 == kSteps;
    const int a = 2 * i, b = 2 * i + 1;
    const int c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
    mesh.faces.emplace_back(a, b, c);
    mesh.faces.emplace_back(c, b, d);
  }
  const MeshInspection i = Inspect(mesh);
  EXPECT_TRUE(i.IsManifold());
  EXPECT_EQ(i.num_misoriented_edges, 1u);
  EXPECT_EQ(i.num_border_edges, 2u * kSteps);
  EXPECT_EQ(i.euler_characteristic, 0);
}

TEST(Inspect, GenusOfATorus) {
  EXPECT_EQ(Inspect(Torus({0, 0, 0}, 1.0, 0.3).Mesh(0.2)).Genus(), 1);
}

TEST(Inspect, EmptyMesh) {
  const MeshInspection i = Inspect(TriangleMesh());
  EXPECT_EQ(i.num_components, 0u);
  EXPECT_EQ(i.area, 0.0);
}

TEST(Inspect, IndexOutOfRangeIsAMistake) {
  TriangleMesh mesh = Tetrahedron();
  mesh.faces[2][1] = 4;
  EXPECT_THROW(Inspect(mesh), std::logic_error);
  mesh.faces[2][1] = -1;
  EXPECT_THROW(Inspect(mesh), std::logic_error);
}

}  // namespace
}  // namespace lsmvs
