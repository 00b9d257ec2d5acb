#include "lsmvs/image/image_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

std::string Text(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

class ImageFileTest : public ::testing::Test {
 protected:
  std::string Write(const std::string& bytes) {
    const std::string path = (folder_.path() / "image").string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  TemporaryFolder folder_;
};

TEST_F(ImageFileTest, TellsTheSizeOfJpegAndPng) {
  const ColorImage image(37, 21, Color(10, 20, 30));
  for (const auto& bytes : {EncodePng(image), EncodeJpeg(image, 90)}) {
    const auto size = InspectImageFile(Write(Text(bytes)));
    ASSERT_TRUE(size);
    EXPECT_EQ(*size, Eigen::Vector2i(37, 21));
  }
}

TEST_F(ImageFileTest, EveryCutIsFound) {
  ColorImage image(16, 16);
  for (size_t i = 0; i < image.size(); ++i) image.pixels[i] = Color(static_cast<uint8_t>(i), 7, 9);
  for (const auto& whole : {Text(EncodePng(image)), Text(EncodeJpeg(image, 90))}) {
    // From where the format can be recognised to where all pixels are there (a PNG ends with a
    // checksum of 4 bytes).
    for (size_t length = 16; length < whole.size() - 4; ++length) {
      EXPECT_THROW(InspectImageFile(Write(whole.substr(0, length))), InputError) << length;
    }
  }
}

TEST_F(ImageFileTest, OtherFilesAreNotJudged) {
  EXPECT_FALSE(InspectImageFile(Write("P6 2 2 255 abcdefghijkl")));
  EXPECT_THROW(InspectImageFile((folder_.path() / "missing").string()), InputError);
}

}  // namespace
}  // namespace lsmvs
