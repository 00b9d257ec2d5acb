#include "lsmvs/image/image_store.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/image/sampling.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {
namespace {

// Brightness that is linear over the field of view, whatever the resolution.
ColorImage Ramp(int width, int height) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto value =
          static_cast<uint8_t>(std::lround(20 + 150 * (x + 0.5) / width + 60 * (y + 0.5) / height));
      image(x, y) = Color(value, value, value);
    }
  }
  return image;
}

class ImageStoreTest : public ::testing::Test {
 protected:
  ImageSource Save(const std::string& name, const ColorImage& image) {
    const std::string path = (folder_.path() / name).string();
    WritePng(path, image);
    const double focal = 1.1 * image.width;
    return {
        path, "", {image.width, image.height, focal, focal, 0.5 * image.width, 0.5 * image.height}};
  }
  ImageSource SaveMat(const std::string& name, const cv::Mat& image) {
    const std::string path = (folder_.path() / name).string();
    constexpr int kNone = 1;  // else three floats become 16 bits of LogLuv
    cv::imwrite(path, image, {cv::IMWRITE_TIFF_COMPRESSION, kNone});
    return {path, "", {image.cols, image.rows, 50, 50, 0.5 * image.cols, 0.5 * image.rows}};
  }
  static std::string ErrorOf(const ImageStore& store) {
    try {
      store.Gray(0, 0);
    } catch (const InputError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(ImageStoreTest, DecodesColoursAndTheGreyOfTheirWeights) {
  ColorImage image(4, 2, Color(0, 0, 0));
  image(0, 0) = Color(255, 0, 0);
  image(1, 0) = Color(0, 255, 0);
  image(2, 0) = Color(0, 0, 255);
  image(3, 0) = Color(255, 255, 255);
  const ImageStore store({Save("a.png", image)}, {});
  EXPECT_EQ(store.Colors(0, 0)->pixels, image.pixels);
  const auto gray = store.Gray(0, 0);
  EXPECT_NEAR((*gray)(0, 0), 0.299 * 255, 1.0);
  EXPECT_NEAR((*gray)(1, 0), 0.587 * 255, 1.0);
  EXPECT_NEAR((*gray)(2, 0), 0.114 * 255, 1.0);
  EXPECT_NEAR((*gray)(3, 0), 255, 1e-3);
  EXPECT_EQ((*gray)(3, 1), 0.0f);
  EXPECT_EQ(store.Mask(0, 0), nullptr);
}

// Cameras for machine vision write 10 to 14 bits into 16. White is the same for all photos, so that
// one that is darker stays so.
TEST_F(ImageStoreTest, SixteenBitsKeepTheirPrecisionAndShareTheirWhite) {
  cv::Mat bright(3, 40, CV_16UC1), dark(3, 40, CV_16UC3);
  for (int x = 0; x < 40; ++x) {
    for (int y = 0; y < 3; ++y) {
      bright.at<uint16_t>(y, x) = static_cast<uint16_t>(100 * x);
      const auto value = static_cast<uint16_t>(10 * x + 3);
      dark.at<cv::Vec3w>(y, x) = {value, value, value};
    }
  }
  for (const std::string extension : {".tif", ".png"}) {
    const ImageStore store({SaveMat("dark" + extension, dark), SaveMat("b" + extension, bright),
                            Save("eight.png", Ramp(40, 3))},
                           {});
    for (const int x : {0, 7, 39}) {
      EXPECT_NEAR((*store.Gray(0, 0))(x, 1), (10 * x + 3) * 255.0 / 4095, 0.05);
      EXPECT_NEAR((*store.Gray(1, 0))(x, 1), 100 * x * 255.0 / 4095, 0.01);
      EXPECT_NEAR((*store.Colors(1, 0))(x, 2).x(), 100 * x * 255.0 / 4095, 0.51);
    }
    EXPECT_NEAR((*store.Gray(2, 0))(0, 0), 20 + 150 / 80 + 60 / 6, 1.0);
  }
}

TEST_F(ImageStoreTest, FloatsRunFromZeroToOneOrToTheLargest) {
  for (const float white : {1.0f, 255.0f}) {
    cv::Mat gray(2, 11, CV_32FC1), color(2, 11, CV_32FC3);
    for (int x = 0; x < 11; ++x) {
      for (int y = 0; y < 2; ++y) {
        const float value = white * static_cast<float>(x) / 10;
        gray.at<float>(y, x) = value;
        color.at<cv::Vec3f>(y, x) = {value, value, value};
      }
    }
    gray.at<float>(0, 5) = NAN;
    const ImageStore store({SaveMat("g.tif", gray), SaveMat("c.tif", color)}, {});
    for (const int view : {0, 1}) {
      EXPECT_NEAR((*store.Gray(view, 0))(7, 1), 0.7 * 255, 0.01);
      EXPECT_NEAR((*store.Colors(view, 0))(7, 1).y(), 0.7 * 255, 0.51);
    }
    EXPECT_EQ((*store.Gray(0, 0))(5, 0), 0.0f);
  }
}

// Thermal cameras write absolute temperatures: a small range far above 0.
TEST_F(ImageStoreTest, ASmallRangeFarAboveZeroIsStretched) {
  cv::Mat cold(20, 100, CV_16UC1), warm(20, 100, CV_16UC1);
  for (int x = 0; x < 100; ++x) {
    cold.col(x).setTo(29000 + 5 * x);
    warm.col(x).setTo(29500 + 5 * x);
  }
  const ImageStore store({SaveMat("c.tif", cold), SaveMat("w.tif", warm)}, {});
  EXPECT_LT((*store.Gray(0, 0))(0, 3), 15);
  EXPECT_GT((*store.Gray(1, 0))(99, 3), 240);
  // The same temperature is the same grey in both.
  EXPECT_NEAR((*store.Gray(0, 0))(99, 3) + 1.2, (*store.Gray(1, 0))(0, 3), 0.3);
}

TEST_F(ImageStoreTest, AlphaOfZeroIsMasked) {
  cv::Mat image(4, 8, CV_8UC4, cv::Scalar(10, 20, 30, 255));
  image(cv::Rect(0, 0, 3, 4)).setTo(cv::Scalar(10, 20, 30, 0));
  ImageSource source = SaveMat("a.png", image);
  EXPECT_TRUE(HasAlpha(source.path));
  EXPECT_EQ(ImageStore({source}, {}).Mask(0, 0), nullptr);
  source.alpha_is_mask = true;
  const ImageStore store({source}, {});
  EXPECT_EQ((*store.Mask(0, 0))(2, 1), 0);
  EXPECT_NE((*store.Mask(0, 0))(3, 1), 0);
  EXPECT_EQ((*store.Colors(0, 0))(0, 0), Color(30, 20, 10));
  // Together with a mask file.
  cv::Mat mask(4, 8, CV_8UC1, cv::Scalar(255));
  mask.row(3).setTo(0);
  source.mask_path = SaveMat("m.png", mask).path;
  const ImageStore both({source}, {});
  EXPECT_EQ((*both.Mask(0, 0))(2, 1), 0);
  EXPECT_EQ((*both.Mask(0, 0))(5, 3), 0);
  EXPECT_NE((*both.Mask(0, 0))(5, 2), 0);
  // Alpha that is 0 everywhere says nothing.
  image.setTo(cv::Scalar(1, 2, 3, 0));
  source = SaveMat("none.png", image);
  source.alpha_is_mask = true;
  EXPECT_NE((*ImageStore({source}, {}).Mask(0, 0))(0, 0), 0);
}

TEST_F(ImageStoreTest, AMissingPhotoIsBlackAndMasked) {
  ImageSource source{"/no/such/photo.png", "", {12, 8, 10, 10, 6, 4}};
  source.is_missing = true;
  const ImageStore store({source}, {});
  EXPECT_EQ(store.Gray(0, 1)->width, 6);
  EXPECT_EQ((*store.Colors(0, 0))(3, 3), Color(0, 0, 0));
  for (const uint8_t used : store.Mask(0, 1)->pixels) EXPECT_EQ(used, 0);
}

TEST_F(ImageStoreTest, LevelsShowTheSameFieldOfViewAsTheirCameras) {
  // Sizes that do not halve evenly.
  for (const Eigen::Vector2i& size : {Eigen::Vector2i(64, 48), Eigen::Vector2i(61, 47)}) {
    const ImageStore store({Save("a.png", Ramp(size.x(), size.y()))}, {});
    const PinholeCamera full = store.Camera(0, 0);
    const auto full_gray = store.Gray(0, 0);
    for (int level = 1; level <= 3; ++level) {
      const PinholeCamera camera = store.Camera(0, level);
      const auto gray = store.Gray(0, level);
      ASSERT_EQ(gray->width, camera.width);
      ASSERT_EQ(gray->height, camera.height);
      EXPECT_EQ(camera.width, std::lround(static_cast<double>(size.x()) / (1 << level)));
      for (int y = 1; y < camera.height - 1; ++y) {
        for (int x = 1; x < camera.width - 1; ++x) {
          // The same ray in the full image has the same brightness.
          const Eigen::Vector2d p = full.Project(camera.PixelRay(x, y));
          EXPECT_NEAR((*gray)(x, y), SampleBilinear(*full_gray, p.x(), p.y()).value, 0.6);
        }
      }
    }
  }
}

TEST_F(ImageStoreTest, MaxImageSizeIsLevelZero) {
  ImageStoreOptions options;
  options.max_image_size = 40;
  const ImageStore store({Save("a.png", Ramp(64, 48)), Save("b.png", Ramp(32, 24))}, options);
  EXPECT_EQ(store.Camera(0, 0).width, 40);
  EXPECT_EQ(store.Camera(0, 0).height, 30);
  EXPECT_EQ(store.Camera(0, 1).width, 20);
  EXPECT_EQ(store.Camera(1, 0).width, 32);
  EXPECT_EQ(store.Gray(0, 0)->width, 40);
  EXPECT_EQ(store.Colors(0, 1)->height, 15);
  // Tiny levels stay images.
  EXPECT_EQ(store.Camera(0, 20).width, 1);
  EXPECT_EQ(store.Gray(0, 20)->size(), 1u);
}

TEST_F(ImageStoreTest, ReducedMaskUsesOnlyPixelsThatAreWhollyUsed) {
  ColorImage mask(128, 64, Color(9, 9, 9));  // any value but 0 is used
  mask(70, 3) = Color(0, 0, 0);
  ImageSource source = Save("a.png", Ramp(128, 64));
  source.mask_path = Save("m.png", mask).path;
  const ImageStore store({source}, {});
  for (int level = 0; level <= 6; ++level) {
    const auto reduced = store.Mask(0, level);
    ASSERT_NE(reduced, nullptr);
    for (int y = 0; y < reduced->height; ++y) {
      for (int x = 0; x < reduced->width; ++x) {
        const bool ignored = x == (70 >> level) && y == (3 >> level);
        EXPECT_EQ((*reduced)(x, y) == 0, ignored) << level << " " << x << " " << y;
      }
    }
  }
}

TEST_F(ImageStoreTest, HoldsNoMoreThanTheBudget) {
  std::vector<ImageSource> sources;
  for (int i = 0; i < 6; ++i) sources.push_back(Save(std::to_string(i) + ".png", Ramp(50, 40)));
  ImageStoreOptions options;
  options.budget_bytes = 3 * 50 * 40 * sizeof(float);
  const ImageStore store(sources, options);
  std::vector<std::weak_ptr<const GrayImage>> seen;
  for (int i = 0; i < 6; ++i) {
    seen.push_back(store.Gray(i, 0));
    EXPECT_LE(store.HeldBytes(), options.budget_bytes);
  }
  EXPECT_EQ(store.HeldBytes(), options.budget_bytes);
  EXPECT_TRUE(seen[2].expired());
  EXPECT_FALSE(seen[3].expired());
  // Using an image keeps it: 3 is touched, so 4 goes first.
  store.Gray(3, 0);
  store.Gray(0, 0);
  EXPECT_FALSE(seen[3].expired());
  EXPECT_TRUE(seen[4].expired());
  const auto held = store.Gray(5, 0);
  store.Trim(2 * 50 * 40 * sizeof(float));
  EXPECT_EQ(store.HeldBytes(), 2 * 50 * 40 * sizeof(float));
  EXPECT_TRUE(seen[3].expired());
  store.Trim(0);
  EXPECT_EQ(store.HeldBytes(), 0u);
  EXPECT_EQ(held->width, 50);
  EXPECT_EQ(store.Gray(5, 0)->pixels, held->pixels);
}

TEST_F(ImageStoreTest, ImageLargerThanTheBudgetIsStillGiven) {
  ImageStoreOptions options;
  options.budget_bytes = 10;
  const ImageStore store({Save("a.png", Ramp(50, 40)), Save("b.png", Ramp(50, 40))}, options);
  const auto a = store.Gray(0, 0);
  const auto b = store.Gray(1, 0);
  EXPECT_EQ(a->pixels, b->pixels);
  EXPECT_LE(store.HeldBytes(), 50 * 40 * sizeof(float));
}

TEST_F(ImageStoreTest, ManyThreadsGetTheSameImages) {
  std::vector<ImageSource> sources;
  for (int i = 0; i < 4; ++i) {
    sources.push_back(Save(std::to_string(i) + ".png", Ramp(30 + i, 20)));
  }
  ImageStoreOptions options;
  options.budget_bytes = 2 * 30 * 20 * sizeof(float);
  const ImageStore store(sources, options);
  std::atomic<int> wrong = 0;
  ParallelFor(RunContext(4), 200, 1, [&](size_t i) {
    const int view = static_cast<int>(i % 4);
    const auto gray = store.Gray(view, static_cast<int>(i / 4 % 2));
    wrong += gray->width != store.Camera(view, static_cast<int>(i / 4 % 2)).width;
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(store.HeldBytes(), options.budget_bytes);
}

TEST_F(ImageStoreTest, BadFilesAreNamed) {
  const ImageSource good = Save("a.png", Ramp(20, 10));
  ImageSource missing = good;
  missing.path += ".not";
  EXPECT_NE(ErrorOf(ImageStore({missing}, {})).find("a.png.not: image file is missing"),
            std::string::npos);
  ImageSource wrong_size = good;
  wrong_size.camera.width = 21;
  EXPECT_NE(ErrorOf(ImageStore({wrong_size}, {})).find("20 x 10 pixels, but its camera is 21 x 10"),
            std::string::npos);
  ImageSource text = good;
  text.path = (folder_.path() / "text.jpg").string();
  WriteFileAtomically(text.path, "not an image at all, but long enough to look at");
  EXPECT_NE(ErrorOf(ImageStore({text}, {})).find("text.jpg"), std::string::npos);
  ImageSource empty = good;
  empty.path = (folder_.path() / "empty.png").string();
  WriteFileAtomically(empty.path, "");
  EXPECT_NE(ErrorOf(ImageStore({empty}, {})).find("empty.png"), std::string::npos);
}

TEST_F(ImageStoreTest, FailedImageCanBeAskedForAgain) {
  ImageSource source = Save("a.png", Ramp(20, 10));
  std::filesystem::rename(source.path, source.path + ".away");
  const ImageStore store({source}, {});
  EXPECT_THROW(store.Gray(0, 0), InputError);
  std::filesystem::rename(source.path + ".away", source.path);
  EXPECT_EQ(store.Gray(0, 0)->width, 20);
}

TEST_F(ImageStoreTest, ReadImageSizeNeedsNoCamera) {
  EXPECT_EQ(ReadImageSize(Save("a.png", Ramp(33, 12)).path), Eigen::Vector2i(33, 12));
  EXPECT_THROW(ReadImageSize((folder_.path() / "none.png").string()), InputError);
}

}  // namespace
}  // namespace lsmvs
