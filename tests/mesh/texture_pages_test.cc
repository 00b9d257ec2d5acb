#include "lsmvs/mesh/texture_pages.h"

#include <gtest/gtest.h>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/texture_charts.h"
#include "lsmvs/synthetic/analytic_shapes.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

Color ColorAt(const Eigen::Vector3d& x) {
  return (127.5 + 100 * x.array().sin()).matrix().cast<uint8_t>();
}

TEST(TexturePages, SamplesShowWhatWasPainted) {
  const TemporaryFolder folder;
  AtlasOptions options;
  options.page_width = options.page_height = 128;
  const TexturedMesh textured =
      PaintAtlas(Sphere({0, 0, 0}, 1).Mesh(0.6), ColorAt, folder.path(), options);
  ASSERT_GT(textured.pages.size(), 2u);
  for (const size_t budget : {size_t{0}, size_t{1} << 30}) {  // with and without reading anew
    const TexturePages pages(textured, budget);
    for (size_t f = 0; f < textured.mesh.faces.size(); f += 7) {
      const Eigen::Vector3i& face = textured.mesh.faces[f];
      const Eigen::Vector3d x = 0.5 * textured.mesh.vertices[face[0]] +
                                0.2 * textured.mesh.vertices[face[1]] +
                                0.3 * textured.mesh.vertices[face[2]];
      const Eigen::Vector3f error = pages.Sample(f, {0.2f, 0.3f}) - ColorAt(x).cast<float>();
      EXPECT_LT(error.cwiseAbs().maxCoeff(), 1.5f);
    }
  }
}

TEST(TexturePages, PagesInUseStayAndMissingOnesAreNamed) {
  const TemporaryFolder folder;
  TexturedMesh textured;
  for (const char* name : {"a.png", "b.png"}) {
    WritePng(folder.path() / name, ColorImage(8, 8, Color(name[0] == 'a' ? 1 : 2, 0, 0)));
    textured.pages.push_back(folder.path() / name);
  }
  const TexturePages pages(textured, 0);
  const auto a = pages.Page(0), b = pages.Page(1);
  EXPECT_EQ((*a)(3, 3), Color(1, 0, 0));
  EXPECT_EQ((*b)(3, 3), Color(2, 0, 0));
  std::filesystem::remove(folder.path() / "a.png");
  EXPECT_THROW(TexturePages(textured, 0).Page(0), InputError);
}

TEST(TexturePages, PagesAreDecodedOnceWhateverTheBudget) {
  const TemporaryFolder folder;
  TexturedMesh textured;
  std::vector<ColorImage> truth;
  for (int p = 0; p < 3; ++p) {
    ColorImage page(40 + p, 30);
    for (size_t i = 0; i < page.size(); ++i) {
      page.pixels[i] =
          Color(static_cast<uint8_t>(i), static_cast<uint8_t>(7 * i + 1), static_cast<uint8_t>(p));
    }
    textured.pages.push_back(folder.path() / (std::to_string(p) + ".png"));
    WritePng(textured.pages.back(), page);
    truth.push_back(std::move(page));
  }
  for (const size_t budget : {size_t{0}, size_t{8000}, size_t{1} << 30}) {
    const TexturePages pages(textured, budget);
    for (const size_t p : {0, 1, 2, 1, 0, 2, 0}) {
      EXPECT_EQ(pages.PageSize(p), Eigen::Vector2i(truth[p].width, truth[p].height));
      ColorImage block(20, 20, Color(9, 9, 9));
      pages.CopyBlock(p, {5, 6}, {10, 9}, {3, 2}, &block);
      EXPECT_EQ(block(2, 2), Color(9, 9, 9));
      EXPECT_EQ(block(13, 10), Color(9, 9, 9));
      for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < 10; ++x) EXPECT_EQ(block(3 + x, 2 + y), truth[p](5 + x, 6 + y));
      }
      if (p == 1) {
        EXPECT_EQ(pages.Page(p)->pixels, truth[p].pixels);
      }
    }
    EXPECT_EQ(pages.num_decoded(), 3u);
  }
}

TEST(TexturePages, SamplingIsBilinearAndClamped) {
  ColorImage image(2, 1);
  image(0, 0) = Color(0, 10, 20);
  image(1, 0) = Color(100, 110, 120);
  EXPECT_EQ(SampleColor(image, {0.5f, 0.5f}), Eigen::Vector3f(0, 10, 20));
  EXPECT_EQ(SampleColor(image, {1.0f, 0.5f}), Eigen::Vector3f(50, 60, 70));
  EXPECT_EQ(SampleColor(image, {-5, 9}), Eigen::Vector3f(0, 10, 20));
  EXPECT_EQ(SampleColor(image, {99, -9}), Eigen::Vector3f(100, 110, 120));
}

TEST(TextureCharts, JoinOverEdgesThatGoOn) {
  TexturedMesh square;
  square.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(FindTextureCharts(square).num_charts, 0);
  square.pages = {"a.png", "b.png"};
  square.page_width = square.page_height = 8;
  const Eigen::Vector2f a(0, 0), b(8, 0), c(8, 8), d(0, 8);
  square.texcoords = {{a, b, c}, {a, c, d}};
  square.page_idx = {0, 0};
  EXPECT_EQ(FindTextureCharts(square).num_charts, 1);
  square.page_idx = {0, 1};
  EXPECT_EQ(FindTextureCharts(square).num_charts, 2);
  square.page_idx = {0, 0};
  square.texcoords[1][1] += Eigen::Vector2f(0, 0.5f);
  EXPECT_EQ(FindTextureCharts(square).chart_of_face, (std::vector<int32_t>{0, 1}));
}

}  // namespace
}  // namespace lsmvs
