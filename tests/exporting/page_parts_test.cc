#include "lsmvs/exporting/pages/page_parts.h"

#include <gtest/gtest.h>

#include <set>

#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

TEST(PageParts, EachCornerKeepsItsVertexAndTexture) {
  const TemporaryFolder folder;
  AtlasOptions options;
  options.page_width = 300;
  options.page_height = 200;
  const TexturedMesh textured = PaintAtlas(BlobMesh(0.5), BlobColor, folder.path(), options);
  ASSERT_GT(textured.pages.size(), 1u);
  const std::vector<PagePart> parts = SplitByPage(textured);
  ASSERT_EQ(parts.size(), textured.pages.size());
  size_t face = 0;  // the atlas fills its pages in the order of the faces
  for (const PagePart& part : parts) {
    for (const Eigen::Vector3i& corners : part.faces) {
      ASSERT_EQ(part.page, textured.page_idx[face]);
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(part.vertices[corners[c]], textured.mesh.faces[face][c]);
        EXPECT_EQ(part.uv[corners[c]],
                  Eigen::Vector2f(textured.NormalizedTexcoord(face, c).cast<float>()));
      }
      ++face;
    }
  }
  EXPECT_EQ(face, textured.mesh.faces.size());
}

TEST(PageParts, VerticesAreSharedWhereTheTextureGoesOn) {
  TexturedMesh square;
  square.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {9, 9, 9}};
  square.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(SplitByPage(square).at(0).vertices, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(SplitByPage(square).at(0).page, -1);

  square.pages = {"a.png", "unused.png", "b.png"};
  square.page_width = square.page_height = 8;
  const Eigen::Vector2f a(0, 0), b(8, 0), c(8, 8), d(0, 8);
  square.texcoords = {{a, b, c}, {a, c, d}};
  square.page_idx = {0, 0};
  EXPECT_EQ(SplitByPage(square).at(0).vertices.size(), 4u);
  square.texcoords[1][0] = Eigen::Vector2f(1, 0);  // a seam at vertex 0 alone
  EXPECT_EQ(SplitByPage(square).at(0).vertices.size(), 5u);
  square.page_idx[1] = 2;
  const std::vector<PagePart> parts = SplitByPage(square);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[1].page, 2);
  EXPECT_EQ(parts[1].vertices, (std::vector<int>{0, 2, 3}));
}

}  // namespace
}  // namespace lsmvs
