#include "lsmvs/mesh/face_neighbors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

using testing::ElementsAre;

TEST(FaceNeighbors, LieAcrossTheSides) {
  const TriangleMesh mesh = GridMesh(2);  // faces (0, 1, 2) and (1, 3, 2)
  const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
  EXPECT_THAT(neighbors[0], ElementsAre(-1, 1, -1));
  EXPECT_THAT(neighbors[1], ElementsAre(-1, -1, 0));
}

TEST(FaceNeighbors, AreNoneWhereThreeFacesMeet) {
  const std::vector<Eigen::Vector3i> faces = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  for (const auto& sides : FindFaceNeighbors(faces, 5)) EXPECT_THAT(sides, ElementsAre(-1, -1, -1));
}

}  // namespace
}  // namespace lsmvs
