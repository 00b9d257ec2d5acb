#include "lsmvs/test_support/expect_valid_mesh.h"

#include <gtest/gtest.h>

#include "lsmvs/mesh/inspect.h"

namespace lsmvs {

void ExpectValidMesh(const TriangleMesh& mesh) {
  EXPECT_GT(mesh.faces.size(), 0u);
  for (const Eigen::Vector3d& x : mesh.vertices) ASSERT_TRUE(x.allFinite()) << x.transpose();
  const auto fits = [&](size_t count) { return count == 0 || count == mesh.vertices.size(); };
  EXPECT_TRUE(fits(mesh.vertex_colors.size()));
  EXPECT_TRUE(fits(mesh.vertex_normals.size()));
  const MeshInspection inspection = Inspect(mesh);
  EXPECT_EQ(inspection.num_nonmanifold_edges, 0u);
  EXPECT_EQ(inspection.num_nonmanifold_vertices, 0u);
  EXPECT_EQ(inspection.num_misoriented_edges, 0u);
  EXPECT_EQ(inspection.num_degenerate_faces, 0u);
  EXPECT_EQ(inspection.num_duplicate_faces, 0u);
  EXPECT_EQ(inspection.num_unused_vertices, 0u);
}

void ExpectValidClosedMesh(const TriangleMesh& mesh) {
  ExpectValidMesh(mesh);
  EXPECT_EQ(Inspect(mesh).num_border_edges, 0u);
}

}  // namespace lsmvs
