#include "lsmvs/image/image_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
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
    const auto info = InspectImageFile(Write(Text(bytes)));
    ASSERT_TRUE(info);
    EXPECT_EQ(info->size, Eigen::Vector2i(37, 21));
    EXPECT_EQ(info->bits_per_channel, 8);
    EXPECT_FALSE(info->has_alpha);
  }
}

TEST_F(ImageFileTest, TellsDepthAndAlphaOfPngAndTiff) {
  for (const std::string extension : {".png", ".tif"}) {
    for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4, CV_32FC3}) {
      if (extension == ".png" && CV_MAT_DEPTH(type) == CV_32F) continue;
      const std::string path = (folder_.path() / ("i" + extension)).string();
      constexpr int kNone = 1;  // else three floats become 16 bits of LogLuv
      cv::imwrite(path, cv::Mat(6, 9, type, cv::Scalar(1, 2, 3, 4)),
                  {cv::IMWRITE_TIFF_COMPRESSION, kNone});
      const auto info = InspectImageFile(path);
      ASSERT_TRUE(info) << path;
      EXPECT_EQ(info->size, Eigen::Vector2i(9, 6));
      EXPECT_EQ(info->bits_per_channel, 8 * CV_ELEM_SIZE1(type)) << path << type;
      EXPECT_EQ(info->has_alpha, CV_MAT_CN(type) == 4) << path << type;
    }
  }
}

TEST_F(ImageFileTest, CutTiffsAreSurvived) {
  const std::string path = (folder_.path() / "i.tif").string();
  cv::imwrite(path, cv::Mat(6, 9, CV_16UC3, cv::Scalar(1, 2, 3)));
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  for (size_t length = 8; length < whole.size(); ++length) {
    try {
      InspectImageFile(Write(whole.substr(0, length)));
    } catch (const InputError&) {
    }
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
