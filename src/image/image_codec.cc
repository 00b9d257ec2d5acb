#include "lsmvs/image/image_codec.h"

#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

static_assert(sizeof(Color) == 3);

cv::Mat View(const ColorImage& image) {
  LSMVS_CHECK(!image.empty());
  return cv::Mat(image.height, image.width, CV_8UC3, const_cast<Color*>(image.pixels.data()));
}

ColorImage FromBgr(const cv::Mat& bgr) {
  ColorImage image(bgr.cols, bgr.rows);
  cv::Mat target(bgr.rows, bgr.cols, CV_8UC3, image.pixels.data());
  cv::cvtColor(bgr, target, cv::COLOR_BGR2RGB);
  return image;
}

std::vector<uint8_t> Encode(const ColorImage& image, const char* extension,
                            const std::vector<int>& parameters) {
  cv::Mat bgr;
  cv::cvtColor(View(image), bgr, cv::COLOR_RGB2BGR);
  std::vector<uint8_t> bytes;
  LSMVS_CHECK(cv::imencode(extension, bgr, bytes, parameters));
  return bytes;
}

void WriteBytes(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
  WriteFileAtomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

std::vector<uint8_t> EncodePng(const ColorImage& image) {
  return Encode(image, ".png", {cv::IMWRITE_PNG_COMPRESSION, 6});
}

std::vector<uint8_t> EncodeJpeg(const ColorImage& image, int quality) {
  LSMVS_CHECK_GE(quality, 1);
  LSMVS_CHECK_LE(quality, 100);
  return Encode(image, ".jpg", {cv::IMWRITE_JPEG_QUALITY, quality});
}

std::vector<uint8_t> EncodeWebp(const ColorImage& image, int quality) {
  LSMVS_CHECK_GE(quality, 1);
  LSMVS_CHECK_LE(quality, 100);
  return Encode(image, ".webp", {cv::IMWRITE_WEBP_QUALITY, quality});
}

ColorImage DecodeColors(const std::vector<uint8_t>& bytes, const std::string& name) {
  cv::Mat bgr;
  try {
    if (!bytes.empty()) bgr = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    bgr.release();
  }
  if (bgr.empty()) {
    throw InputError(name, "cannot be decoded as an image", "export the image again");
  }
  return FromBgr(bgr);
}

void WritePng(const std::filesystem::path& path, const ColorImage& image) {
  WriteBytes(path, EncodePng(image));
}

void WriteJpeg(const std::filesystem::path& path, const ColorImage& image, int quality) {
  WriteBytes(path, EncodeJpeg(image, quality));
}

ColorImage ReadColors(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), "cannot be opened", "check that it exists");
  const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  return DecodeColors(bytes, path.string());
}

ColorImage ResizeColors(const ColorImage& image, int width, int height) {
  LSMVS_CHECK(width >= 1 && height >= 1);
  ColorImage resized(width, height);
  cv::Mat target(height, width, CV_8UC3, resized.pixels.data());
  const bool smaller = width <= image.width && height <= image.height;
  cv::resize(View(image), target, target.size(), 0, 0, smaller ? cv::INTER_AREA : cv::INTER_CUBIC);
  return resized;
}

}  // namespace lsmvs
