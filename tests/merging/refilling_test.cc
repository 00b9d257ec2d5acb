#include "lsmvs/merging/zip/refilling.h"

#include <gtest/gtest.h>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/synthetic/overlapping_pieces.h"
#include "lsmvs/test_support/expect_valid_mesh.h"

namespace lsmvs {
namespace {

size_t NumCrossings(const TriangleMesh& mesh) {
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  return FaceGrid(mesh.vertices, mesh.faces).CrossingPairs(all, RunContext(1)).size();
}

TriangleMesh Refilled(TriangleMesh mesh) {
  std::vector<Eigen::Vector3d> normals;
  for (const Eigen::Vector3f& n : ComputeVertexNormals(ReliefMesh(0.5, 1))) {
    normals.push_back(n.cast<double>());
  }
  const Refilling refilling =
      RefillCrossings(mesh, normals, std::vector<uint8_t>(mesh.vertices.size(), 1),
                      std::vector<uint8_t>(mesh.faces.size(), 1), RunContext(2));
  FilterFaces(&mesh, [&](size_t f) { return !refilling.is_dropped[f]; });
  mesh.faces.insert(mesh.faces.end(), refilling.faces.begin(), refilling.faces.end());
  RemoveUnusedVertices(&mesh);
  return mesh;
}

// A vertex that was pulled through faces nearby.
TEST(RefillCrossings, TakesOutATangle) {
  TriangleMesh mesh = ReliefMesh(0.5, 1);
  size_t inner = 0;
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    if ((mesh.vertices[v].head<2>() - Eigen::Vector2d(5, 3)).norm() < 0.4) inner = v;
  }
  const double area = Inspect(mesh).area;
  mesh.vertices[inner] += Eigen::Vector3d(1.7, 0.2, -0.4);
  ASSERT_GT(NumCrossings(mesh), 0u);
  const TriangleMesh refilled = Refilled(mesh);
  EXPECT_EQ(NumCrossings(refilled), 0u);
  ExpectValidMesh(refilled);
  EXPECT_EQ(Inspect(refilled).euler_characteristic, 1);
  EXPECT_NEAR(Inspect(refilled).area / area, 1, 0.02);
}

TEST(RefillCrossings, LeavesWhatDoesNotCross) {
  const TriangleMesh mesh = ReliefMesh(0.5, 1);
  EXPECT_EQ(Refilled(mesh).faces, mesh.faces);
}

}  // namespace
}  // namespace lsmvs
