#include "lsmvs/exporting/page_files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

ColorImage Gradient(int width, int height) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = Color(static_cast<uint8_t>(4 * x), static_cast<uint8_t>(4 * y), 90);
    }
  }
  return image;
}

std::vector<uint8_t> Bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class PageFilesTest : public ::testing::Test {
 protected:
  PageFilesTest() {
    WritePng(folder_.path() / "a.png", Gradient(40, 30));
    WriteJpeg(folder_.path() / "b.jpg", Gradient(40, 30), 95);
    textured_.pages = {folder_.path() / "a.png", folder_.path() / "b.jpg"};
  }
  TemporaryFolder folder_;
  TexturedMesh textured_;
};

TEST_F(PageFilesTest, PagesBesideTheMeshStay) {
  const auto targets = PageTargets(textured_, folder_.path() / "out.obj", {});
  EXPECT_EQ(targets, textured_.pages);
  WritePages(textured_, targets, {});
  EXPECT_EQ(ReadColors(targets[0]).pixels, Gradient(40, 30).pixels);
}

TEST_F(PageFilesTest, PagesElsewhereAreCopiedByteByByte) {
  const fs::path out = folder_.path() / "sub" / "model.obj";
  const auto targets = PageTargets(textured_, out, {});
  EXPECT_EQ(targets[0], folder_.path() / "sub" / "model_0.png");
  EXPECT_EQ(targets[1], folder_.path() / "sub" / "model_1.jpg");
  WritePages(textured_, targets, {});
  for (size_t p = 0; p < 2; ++p) EXPECT_EQ(Bytes(targets[p]), Bytes(textured_.pages[p]));
}

TEST_F(PageFilesTest, FormatsAreConverted) {
  for (const auto& [format, extension] : {std::pair(TextureFormat::kPng, ".png"),
                                          {TextureFormat::kJpeg, ".jpg"},
                                          {TextureFormat::kWebp, ".webp"}}) {
    const TextureEncoding encoding = {format, 95};
    const auto targets = PageTargets(textured_, folder_.path() / "x" / "m.ply", encoding);
    WritePages(textured_, targets, encoding);
    for (const fs::path& target : targets) {
      EXPECT_EQ(target.extension(), extension);
      const ColorImage image = ReadColors(target);
      double sum = 0;
      for (size_t i = 0; i < image.size(); ++i) {
        sum += (image.pixels[i].cast<double>() - Gradient(40, 30).pixels[i].cast<double>())
                   .cwiseAbs()
                   .mean();
      }
      EXPECT_LT(sum / static_cast<double>(image.size()), 4) << target;
    }
  }
}

TEST_F(PageFilesTest, BrokenPagesAreNamed) {
  textured_.pages[0] = folder_.path() / "gone.png";
  EXPECT_THROW(PageTargets(textured_, folder_.path() / "m.obj", {}), InputError);
  std::ofstream(folder_.path() / "bad.tif") << "this is no image at all";
  EXPECT_THROW(EncodePage(folder_.path() / "bad.tif", {}), InputError);
}

}  // namespace
}  // namespace lsmvs
