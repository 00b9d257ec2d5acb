#include "lsmvs/mesh/repair.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "simple_meshes.h"

namespace lsmvs {
namespace {

const RunContext kContext(1);

// Two tetrahedra that have the first vertex in common, or the first two.
TriangleMesh TwoTetrahedra(bool common_edge) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  for (int v = 0; v < 7; ++v) mesh.vertex_colors.emplace_back(1, 2, 3);
  mesh.vertex_quality = {0.0f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
  const auto add = [&](int a, int b, int c, int d) {
    mesh.faces.insert(mesh.faces.end(), {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}});
  };
  add(0, 1, 2, 3);
  if (common_edge) {
    add(0, 1, 5, 6);
  } else {
    add(0, 5, 4, 6);
  }
  return mesh;
}

TEST(SplitNonManifoldVertices, ACommonVertexIsCopied) {
  TriangleMesh mesh = TwoTetrahedra(false);
  EXPECT_EQ(Inspect(mesh).num_nonmanifold_vertices, 1u);
  EXPECT_EQ(SplitNonManifoldVertices(&mesh), std::vector<int>{0});
  ASSERT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(mesh.vertices[7], mesh.vertices[0]);
  EXPECT_EQ(mesh.vertex_colors.size(), 8u);
  ASSERT_EQ(mesh.vertex_quality.size(), 8u);
  EXPECT_EQ(mesh.vertex_quality[7], mesh.vertex_quality[0]);
  EXPECT_TRUE(Inspect(mesh).IsManifold());
  EXPECT_TRUE(Inspect(mesh).IsClosed());
}

TEST(SplitNonManifoldVertices, FacesPartAtACommonEdge) {
  TriangleMesh mesh = TwoTetrahedra(true);
  EXPECT_EQ(Inspect(mesh).num_nonmanifold_edges, 1u);
  const size_t num_faces = mesh.faces.size();
  SplitNonManifoldVertices(&mesh);
  EXPECT_EQ(mesh.faces.size(), num_faces);
  EXPECT_TRUE(Inspect(mesh).IsManifold());
}

TEST(SplitNonManifoldVertices, AManifoldStaysAsItIs) {
  TriangleMesh mesh = SphereMesh(2);
  const TriangleMesh before = mesh;
  EXPECT_TRUE(SplitNonManifoldVertices(&mesh).empty());
  EXPECT_EQ(mesh.faces, before.faces);
  EXPECT_EQ(mesh.vertices, before.vertices);
}

TEST(FindComponents, CountsFacesInTheirOrder) {
  TriangleMesh mesh = SphereMesh(1);
  const size_t num_faces = mesh.faces.size();
  const int offset = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  mesh.faces.emplace_back(offset, offset + 1, offset + 2);
  const MeshComponents components = FindComponents(mesh);
  EXPECT_EQ(components.num_faces, (std::vector<size_t>{num_faces, 1}));
  EXPECT_EQ(components.of_face.front(), 0);
  EXPECT_EQ(components.of_face.back(), 1);
}

TEST(FilterFaces, KeepsTheOrder) {
  TriangleMesh mesh = SphereMesh(1);
  const auto faces = mesh.faces;
  const size_t num_dropped = FilterFaces(&mesh, [](size_t f) { return f % 3 == 0; });
  EXPECT_EQ(num_dropped, faces.size() - mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) EXPECT_EQ(mesh.faces[f], faces[3 * f]);
}

TEST(FindBorderLoops, RunAsNewFacesWould) {
  TriangleMesh mesh = SphereMesh(2);
  EXPECT_TRUE(FindBorderLoops(mesh).empty());
  const Eigen::Vector3i removed = mesh.faces.back();
  mesh.faces.pop_back();
  const auto loops = FindBorderLoops(mesh);
  ASSERT_EQ(loops.size(), 1u);
  ASSERT_EQ(loops[0].size(), 3u);
  // The loop itself is the face that was there, from its lowest vertex on.
  mesh.faces.emplace_back(loops[0][0], loops[0][1], loops[0][2]);
  EXPECT_TRUE(Inspect(mesh).IsOriented());
  EXPECT_EQ(loops[0][0], removed.minCoeff());
}

// The sphere without the faces around some of its vertices.
TriangleMesh SphereWithHoles(const std::set<int>& centers) {
  TriangleMesh mesh = SphereMesh(3);
  const auto faces = mesh.faces;
  FilterFaces(&mesh, [&](size_t f) {
    return !centers.count(faces[f][0]) && !centers.count(faces[f][1]) &&
           !centers.count(faces[f][2]);
  });
  return mesh;
}

TEST(CloseHoles, TheSphereIsWholeAgain) {
  TriangleMesh mesh = SphereWithHoles({0, 5, 40});
  const size_t num_vertices = mesh.vertices.size();
  EXPECT_FALSE(Inspect(mesh).IsClosed());
  EXPECT_EQ(CloseHoles({}, kContext, &mesh), 3u);
  EXPECT_EQ(mesh.vertices.size(), num_vertices);
  RemoveUnusedVertices(&mesh);
  ExpectValidMesh(mesh);
  const MeshInspection inspection = Inspect(mesh);
  EXPECT_TRUE(inspection.IsClosed());
  EXPECT_EQ(inspection.Genus(), 0);
  EXPECT_NEAR(inspection.volume, 4.0 / 3 * std::numbers::pi, 0.15);
}

TEST(CloseHoles, LargeHolesAndRefusedFacesStay) {
  TriangleMesh mesh = SphereWithHoles({0});
  const size_t num_edges = Inspect(mesh).num_border_edges;
  HoleClosingOptions options;
  options.max_num_edges = static_cast<int>(num_edges) - 1;
  EXPECT_EQ(CloseHoles(options, kContext, &mesh), 0u);
  options.max_num_edges = static_cast<int>(num_edges);
  options.accept = [](const Eigen::Vector3i&) { return false; };
  EXPECT_EQ(CloseHoles(options, kContext, &mesh), 0u);
  EXPECT_EQ(Inspect(mesh).num_border_edges, num_edges);
  size_t num_asked = 0;
  options.accept = [&](const Eigen::Vector3i&) { return ++num_asked > 0; };
  EXPECT_EQ(CloseHoles(options, kContext, &mesh), 1u);
  EXPECT_GT(num_asked, 0u);
  EXPECT_TRUE(Inspect(mesh).IsClosed());
}

TEST(CloseHoles, NoEdgeIsRepeated) {
  // Four faces of an octahedron around its equator's corners: closing the two holes by the same
  // diagonal would join them.
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  EXPECT_EQ(CloseHoles({}, kContext, &mesh), 1u);
  EXPECT_TRUE(Inspect(mesh).IsClosed());
  EXPECT_TRUE(Inspect(mesh).IsManifold());
  EXPECT_GT(Inspect(mesh).volume, 0);
}

TEST(CloseHoles, WhatAnotherSurfacePassesThroughStaysOpen) {
  TriangleMesh mesh = SphereWithHoles({0, 5, 40});
  const Eigen::Vector3d x = mesh.vertices[5];
  // A spike through the second hole.
  const int spike = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(),
                       {0.5 * x, 1.5 * x, 0.5 * x + Eigen::Vector3d(1e-3, 2e-3, 1e-3)});
  mesh.faces.emplace_back(spike, spike + 1, spike + 2);
  HoleClosingOptions options;
  options.max_num_edges = 10;
  const size_t num_faces = mesh.faces.size();
  EXPECT_EQ(CloseHoles(options, kContext, &mesh), 2u);
  EXPECT_GT(mesh.faces.size(), num_faces);
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  EXPECT_TRUE(FaceGrid(mesh.vertices, mesh.faces).CrossingPairs(all, kContext).empty());
}

}  // namespace
}  // namespace lsmvs
