#include "lsmvs/workflow/files/mesh_with_views.h"

#include <gtest/gtest.h>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

TriangleMesh OneTriangle() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}};
  return mesh;
}

TEST(MeshWithViews, ComesBackWithItsViewsAndItsOffset) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "mesh.ply";
  const PointViews views{{0, 2, 2, 3}, {0, 4, 1}};
  WriteMeshWithViews(path, OneTriangle(), {100, 0, 0}, views);
  EXPECT_EQ(ReadMeshPly(path).vertices[1], Eigen::Vector3d(101, 0, 0));
  const std::optional<PointViews> read = ReadViewsOf(path, 3);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->begin, views.begin);
  EXPECT_EQ(read->view_idxs, views.view_idxs);
}

TEST(MeshWithViews, ViewsOfTheMeshBeforeAreRemoved) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "mesh.ply";
  WriteMeshWithViews(path, OneTriangle(), Eigen::Vector3d::Zero(), PointViews{{0, 0, 0, 0}, {}});
  for (const std::filesystem::path& file : MeshWithViewsFiles(path)) {
    EXPECT_TRUE(std::filesystem::exists(file)) << file;
  }
  WriteMeshWithViews(path, OneTriangle(), Eigen::Vector3d::Zero(), std::nullopt);
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_FALSE(ReadViewsOf(path, 3));
}

}  // namespace
}  // namespace lsmvs
