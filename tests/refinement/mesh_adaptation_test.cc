#include "lsmvs/refinement/step/mesh_adaptation.h"

#include <gtest/gtest.h>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/test_support/expect_valid_mesh.h"

namespace lsmvs {
namespace {

constexpr int kSide = 9;

// A sheet of squares of side 2 whose diagonals are the long ones in two places, both raised so that
// a flip lowers the surface there by 0.06.
void AddSheet(double z, TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) mesh->vertices.push_back({2.0 * x, 2.0 * y, z});
  }
  for (int y = 0; y + 1 < kSide; ++y) {
    for (int x = 0; x + 1 < kSide; ++x) {
      const int a = first + y * kSide + x;
      mesh->faces.push_back({a, a + 1, a + kSide});
      mesh->faces.push_back({a + 1, a + kSide + 1, a + kSide});
    }
  }
  for (const int corner : {2 * kSide + 2, 5 * kSide + 5}) {
    const auto at = [&](int offset) -> Eigen::Vector3d& {
      return mesh->vertices[static_cast<size_t>(first + corner + offset)];
    };
    at(1) += Eigen::Vector3d(0.6, -0.6, 0.06);
    at(kSide) += Eigen::Vector3d(-0.6, 0.6, 0.06);
  }
}

size_t NumCrossings(const TriangleMesh& mesh) {
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  return FaceGrid(mesh.vertices, mesh.faces).CrossingPairs(all, RunContext(1)).size();
}

MeshAdaptation Adapt(const std::vector<float>& density, TriangleMesh* mesh) {
  std::vector<Eigen::Vector3d> rest = mesh->vertices;
  MeshAdaptationOptions options;
  options.max_face_area_px = 3.5;
  const MeshAdaptation result = AdaptMesh(options, density, mesh, &rest, RunContext(1));
  EXPECT_EQ(rest, mesh->vertices);
  ExpectValidMesh(*mesh);
  return result;
}

// The second sheet lies closely below one of the two places of the first one, and stays as it is.
TEST(MeshAdaptation, FlipsWhatItMayAndNothingIntoAnotherSheet) {
  TriangleMesh alone;
  AddSheet(0, &alone);
  TriangleMesh both = alone;
  AddSheet(0, &both);
  for (size_t v = alone.vertices.size(); v < both.vertices.size(); ++v) {
    both.vertices[v].z() -= both.vertices[v].x() < 9 ? 0.02 : 5.0;
  }
  ASSERT_EQ(NumCrossings(both), 0u);
  std::vector<float> density(alone.faces.size(), 1.0f);
  const MeshAdaptation free = Adapt(density, &alone);
  EXPECT_EQ(free.num_flips, 2u);
  density.resize(both.faces.size(), 0.0f);
  TriangleMesh adapted = both;
  const MeshAdaptation confined = Adapt(density, &adapted);
  EXPECT_EQ(confined.num_flips, 1u);
  EXPECT_EQ(NumCrossings(adapted), 0u);
}

// What crosses from the start is not the adaptation's to mend, nor a reason to do nothing
// elsewhere.
TEST(MeshAdaptation, LeavesCrossingsOfItsInput) {
  TriangleMesh mesh;
  AddSheet(0, &mesh);
  const int fin = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{13.1, 1.3, -1}, {14.6, 1.2, 1}, {13.9, 1.6, 1}});
  mesh.faces.emplace_back(fin, fin + 1, fin + 2);
  std::vector<float> density(mesh.faces.size(), 1.0f);
  EXPECT_GT(NumCrossings(mesh), 0u);
  EXPECT_EQ(Adapt(density, &mesh).num_flips, 2u);
}

TEST(MeshAdaptation, DoesNothingToWhatNobodySees) {
  TriangleMesh mesh;
  AddSheet(0, &mesh);
  const TriangleMesh before = mesh;
  EXPECT_FALSE(Adapt(std::vector<float>(mesh.faces.size(), 0.0f), &mesh).Any());
  EXPECT_EQ(mesh.faces, before.faces);
  EXPECT_EQ(mesh.vertices, before.vertices);
}

}  // namespace
}  // namespace lsmvs
