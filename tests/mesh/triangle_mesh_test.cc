#include "lsmvs/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include "lsmvs/synthetic/analytic_shapes.h"

namespace lsmvs {
namespace {

TriangleMesh Square() {
  TriangleMesh mesh;
  mesh.vertices = {{9, 9, 9}, {0, 0, 0}, {2, 0, 0}, {8, 8, 8}, {2, 2, 0}, {0, 2, 0}};
  mesh.faces = {{1, 2, 4}, {1, 4, 5}};
  return mesh;
}

TEST(TriangleMesh, FaceNormalIsTwiceTheAreaLongAndFollowsTheOrientation) {
  EXPECT_EQ(FaceNormalTimesTwiceArea(Square(), 0), Eigen::Vector3d(0, 0, 4));
}

TEST(TriangleMesh, VertexNormalsOfASpherePointOutward) {
  const TriangleMesh mesh = Sphere({1, 2, 3}, 2.0).Mesh(0.3);
  const auto normals = ComputeVertexNormals(mesh);
  ASSERT_EQ(normals.size(), mesh.vertices.size());
  for (size_t v = 0; v < normals.size(); ++v) {
    const Eigen::Vector3d outward = (mesh.vertices[v] - Eigen::Vector3d(1, 2, 3)) / 2.0;
    EXPECT_GT(normals[v].cast<double>().dot(outward), 0.999);
    EXPECT_NEAR(normals[v].norm(), 1.0, 1e-6);
  }
}

TEST(TriangleMesh, VerticesWithoutProperFacesHaveNoNormal) {
  TriangleMesh mesh = Square();
  mesh.faces.push_back({0, 0, 3});
  const auto normals = ComputeVertexNormals(mesh);
  EXPECT_EQ(normals[0], Eigen::Vector3f(0, 0, 0));
  EXPECT_EQ(normals[3], Eigen::Vector3f(0, 0, 0));
  EXPECT_EQ(normals[4], Eigen::Vector3f(0, 0, 1));
}

TEST(TriangleMesh, RemoveUnusedVerticesKeepsOrderAndAttributes) {
  TriangleMesh mesh = Square();
  for (int v = 0; v < 6; ++v) {
    mesh.vertex_colors.emplace_back(static_cast<uint8_t>(v), 0, 0);
    mesh.vertex_normals.emplace_back(static_cast<float>(v), 0.0f, 0.0f);
  }
  EXPECT_EQ(RemoveUnusedVertices(&mesh), (std::vector<int>{-1, 0, 1, -1, 2, 3}));
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(2, 2, 0));
  EXPECT_EQ(mesh.faces[1], Eigen::Vector3i(0, 2, 3));
  ASSERT_EQ(mesh.vertex_colors.size(), 4u);
  EXPECT_EQ(mesh.vertex_colors[3][0], 5);
  ASSERT_EQ(mesh.vertex_normals.size(), 4u);
  EXPECT_EQ(mesh.vertex_normals[0].x(), 1.0f);
}

TEST(TriangleMesh, RemoveUnusedVerticesOfNothing) {
  TriangleMesh mesh;
  EXPECT_TRUE(RemoveUnusedVertices(&mesh).empty());
  mesh.vertices = {{0, 0, 0}};
  EXPECT_EQ(RemoveUnusedVertices(&mesh), std::vector<int>{-1});
  EXPECT_TRUE(mesh.vertices.empty());
}

}  // namespace
}  // namespace lsmvs
