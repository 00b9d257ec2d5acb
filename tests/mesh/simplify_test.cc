#include "lsmvs/mesh/simplify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/test_support/expect_valid_mesh.h"

#include "simple_meshes.h"

namespace lsmvs {
namespace {

TriangleMesh Grid(int n, double (*height)(double, double)) {
  TriangleMesh mesh =
      UnitSquareMesh(n, [&](double x, double y) { return Eigen::Vector3d(x, y, height(x, y)); });
  for (const Eigen::Vector3d& x : mesh.vertices) {
    mesh.vertex_colors.emplace_back(static_cast<uint8_t>(255 * x.x()),
                                    static_cast<uint8_t>(255 * x.y()), 0);
  }
  return mesh;
}

double Flat(double, double) { return 0; }
double Wavy(double x, double y) { return 0.1 * std::sin(7 * x) * std::cos(5 * y); }

TEST(Simplify, FlatSquareKeepsItsAreaAndBorder) {
  const SimplifiedMesh result = SimplifyMesh(Grid(20, Flat), 60, RunContext(1));
  EXPECT_LE(result.mesh.faces.size(), 60u);
  ExpectValidMesh(result.mesh);
  EXPECT_NEAR(Inspect(result.mesh).area, 1, 1e-4);
  for (const Eigen::Vector3d& x : result.mesh.vertices) EXPECT_NEAR(x.z(), 0, 1e-9);
}

TEST(Simplify, StaysNearASmoothSurface) {
  const TriangleMesh mesh = Grid(60, Wavy);
  const SimplifiedMesh result = SimplifyMesh(mesh, 1000, RunContext(1));
  EXPECT_LE(result.mesh.faces.size(), 1000u);
  EXPECT_GT(result.mesh.faces.size(), 900u);
  ExpectValidMesh(result.mesh);
  for (const Eigen::Vector3d& x : result.mesh.vertices) {
    EXPECT_NEAR(x.z(), Wavy(x.x(), x.y()), 2e-3);
  }
}

TEST(Simplify, ColoursComeFromTheSource) {
  const TriangleMesh mesh = Grid(40, Wavy);
  const SimplifiedMesh result = SimplifyMesh(mesh, 400, RunContext(1));
  ASSERT_EQ(result.source_vertex.size(), result.mesh.vertices.size());
  for (size_t v = 0; v < result.mesh.vertices.size(); ++v) {
    EXPECT_LT((mesh.vertices[result.source_vertex[v]] - result.mesh.vertices[v]).norm(), 0.15);
    EXPECT_EQ(mesh.vertex_colors[result.source_vertex[v]], result.mesh.vertex_colors[v]);
  }
}

TEST(Simplify, PartKeepsLockedVerticesAndTheirEdges) {
  TriangleMesh mesh = Grid(40, Wavy);
  for (Eigen::Vector3d& x : mesh.vertices) x += Eigen::Vector3d(0.1, 0.2, 0.3);  // rounds
  std::vector<uint8_t> locked(mesh.vertices.size(), 0);
  for (int row = 0; row <= 40; ++row) locked[static_cast<size_t>(41 * row)] = 1;  // the left side
  const SimplifiedMesh result = SimplifyMeshPart(mesh, locked, 400, RunContext(1));
  EXPECT_LE(result.mesh.faces.size(), 400u);
  ExpectValidMesh(result.mesh);
  std::vector<int> index_of(mesh.vertices.size(), -1);
  for (size_t v = 0; v < result.source_vertex.size(); ++v) {
    if (!locked[static_cast<size_t>(result.source_vertex[v])]) continue;
    index_of[static_cast<size_t>(result.source_vertex[v])] = static_cast<int>(v);
    EXPECT_EQ(result.mesh.vertices[v], mesh.vertices[static_cast<size_t>(result.source_vertex[v])]);
  }
  for (int row = 0; row < 40; ++row) {
    const int a = index_of[static_cast<size_t>(41 * row)];
    const int b = index_of[static_cast<size_t>(41 * (row + 1))];
    ASSERT_GE(a, 0);
    ASSERT_GE(b, 0);
    bool has_edge = false;
    for (const Eigen::Vector3i& f : result.mesh.faces) {
      has_edge |= (f.array() == a).any() && (f.array() == b).any();
    }
    EXPECT_TRUE(has_edge) << row;
  }
}

TEST(Simplify, ThinsLargeInputsFirst) {
  const SimplifiedMesh result = SimplifyMesh(Grid(150, Wavy), 500, RunContext(1));
  EXPECT_LE(result.mesh.faces.size(), 500u);
  EXPECT_NEAR(Inspect(result.mesh).area, Inspect(Grid(150, Wavy)).area, 0.06);
}

TEST(Simplify, SmallMeshesStayAsTheyAre) {
  const TriangleMesh mesh = Grid(4, Wavy);
  const SimplifiedMesh result = SimplifyMesh(mesh, 1000, RunContext(1));
  EXPECT_EQ(result.mesh.faces.size(), mesh.faces.size());
  EXPECT_EQ(result.mesh.vertices.size(), mesh.vertices.size());
}

TEST(Simplify, TakesBadInput) {
  TriangleMesh mesh = Grid(20, Wavy);
  mesh.vertices.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  mesh.vertices.emplace_back(7, 7, 7);  // unused
  mesh.vertex_colors.resize(mesh.vertices.size(), mesh.vertex_colors[0]);
  const int nan = static_cast<int>(mesh.vertices.size()) - 2;
  mesh.faces.emplace_back(0, 1, nan);
  mesh.faces.emplace_back(3, 3, 4);
  for (int i = 0; i < 3; ++i) mesh.faces.push_back(mesh.faces[0]);  // the same face four times
  const SimplifiedMesh result = SimplifyMesh(mesh, 200, RunContext(1));
  EXPECT_LE(result.mesh.faces.size(), 220u);
  for (const Eigen::Vector3d& x : result.mesh.vertices) EXPECT_TRUE(x.allFinite());
  EXPECT_TRUE(SimplifyMesh({}, 10, RunContext(1)).mesh.faces.empty());
}

}  // namespace
}  // namespace lsmvs
