#include "lsmvs/image/image_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

ColorImage Gradient(int width, int height) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = Color(static_cast<uint8_t>(5 * x), static_cast<uint8_t>(7 * y), 200);
    }
  }
  return image;
}

TEST(ImageCodec, PngIsLossless) {
  const ColorImage image = Gradient(31, 17);
  const ColorImage back = DecodeColors(EncodePng(image), "memory");
  EXPECT_EQ(back.width, 31);
  EXPECT_EQ(back.height, 17);
  EXPECT_EQ(back.pixels, image.pixels);
}

TEST(ImageCodec, JpegIsNear) {
  const ColorImage image = Gradient(32, 16);
  const ColorImage back = DecodeColors(EncodeJpeg(image, 95), "memory");
  ASSERT_EQ(back.size(), image.size());
  for (size_t i = 0; i < image.size(); ++i) {
    for (int c = 0; c < 3; ++c) EXPECT_LE(std::abs(back.pixels[i][c] - image.pixels[i][c]), 16);
  }
}

TEST(ImageCodec, FilesAndErrors) {
  const TemporaryFolder folder;
  const ColorImage image = Gradient(8, 8);
  WritePng(folder.path() / "a.png", image);
  EXPECT_EQ(ReadColors(folder.path() / "a.png").pixels, image.pixels);
  EXPECT_THROW(ReadColors(folder.path() / "b.png"), InputError);
  EXPECT_THROW(DecodeColors({1, 2, 3}, "memory"), InputError);
  EXPECT_THROW(DecodeColors({}, "memory"), InputError);
}

TEST(ImageCodec, ResizeKeepsTheMean) {
  const ColorImage image = Gradient(40, 20);
  const ColorImage half = ResizeColors(image, 20, 10);
  ASSERT_EQ(half.width, 20);
  ASSERT_EQ(half.height, 10);
  EXPECT_NEAR(half(3, 4)[0], 5 * 6.5, 1);
  EXPECT_NEAR(half(3, 4)[1], 7 * 8.5, 1);
}

}  // namespace
}  // namespace lsmvs
