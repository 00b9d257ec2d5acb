#include "lsmvs/image/image_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "lsmvs/image/image_file.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/lru_cache.h"

namespace lsmvs {

namespace {

constexpr const char* kReexport = "export the image again or remove it from the model";
constexpr const char* kOtherPhoto =
    "use the images that the model was made from, or undistort again";
constexpr const char* kOtherMask = "make the mask of its photo's size, or remove it";

// Empty if it cannot be decoded. Throws InputError if the file is missing or cut off.
cv::Mat TryDecode(const std::string& path, int flags) {
  if (!std::filesystem::is_regular_file(path)) {
    throw InputError(path, "image file is missing", "put it back or remove it from the model");
  }
  InspectImageFile(path);  // throws if it is cut off, which imread would not
  try {
    return cv::imread(path, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

cv::Mat Decode(const std::string& path, int flags) {
  cv::Mat image = TryDecode(path, flags);
  if (image.empty()) throw InputError(path, "cannot be decoded as an image", kReexport);
  return image;
}

bool HasFloats(const std::string& path) {
  const std::optional<ImageFileInfo> info =
      std::filesystem::is_regular_file(path) ? InspectImageFile(path) : std::nullopt;
  return info && info->bits_per_channel > 16;
}

// With the depth of the file; `flags` say whether in grey or in colours. The decoder of floats
// converts neither to grey nor to colours.
cv::Mat DecodeDeep(const std::string& path, int flags) {
  cv::Mat image;
  if (!HasFloats(path)) image = TryDecode(path, flags | cv::IMREAD_ANYDEPTH);
  const int num_channels = flags == cv::IMREAD_GRAYSCALE ? 1 : 3;
  if (image.channels() == num_channels && !image.empty()) return image;
  image = Decode(path, cv::IMREAD_UNCHANGED);
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  if (image.channels() > num_channels) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  if (image.channels() < num_channels) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  return image;
}

cv::Mat DecodeOfSize(const std::string& path, int flags, const PinholeCamera& camera,
                     const char* remedy) {
  cv::Mat image = DecodeDeep(path, flags);
  if (image.cols != camera.width || image.rows != camera.height) {
    throw InputError(path,
                     fmt::format("is {} x {} pixels, but its camera is {} x {}", image.cols,
                                 image.rows, camera.width, camera.height),
                     remedy);
  }
  return image;
}

PinholeCamera LevelCamera(const PinholeCamera& full, int max_image_size, int level) {
  const int longer = std::max(full.width, full.height);
  const double scale = (max_image_size > 0 && longer > max_image_size)
                           ? static_cast<double>(max_image_size) / longer
                           : 1.0;
  const auto reduce = [&](int pixels) {
    return std::max(1, static_cast<int>(std::lround(pixels * scale / (1 << level))));
  };
  return full.Resized(reduce(full.width), reduce(full.height));
}

cv::Mat ResizeTo(const cv::Mat& image, const PinholeCamera& camera) {
  if (image.cols == camera.width && image.rows == camera.height) return image;
  cv::Mat resized;
  cv::resize(image, resized, cv::Size(camera.width, camera.height), 0, 0, cv::INTER_AREA);
  return resized;
}

template <class T>
std::shared_ptr<Raster<T>> ToRaster(const cv::Mat& image) {
  auto raster = std::make_shared<Raster<T>>(image.cols, image.rows);
  for (int row = 0; row < image.rows; ++row) {
    const auto* source = reinterpret_cast<const T*>(image.ptr(row));
    std::copy(source, source + image.cols, raster->Row(row));
  }
  return raster;
}

// Values of more than 8 bits as 0 to 255, in floats.
template <class Range>
cv::Mat Scaled(cv::Mat image, const Range& range) {
  image.convertTo(image, CV_32F);
  cv::patchNaNs(image, range.black);
  const double scale = 255.0 / (range.white - range.black);
  image.convertTo(image, CV_32F, scale, -range.black * scale);
  cv::min(image, 255.0, image);
  cv::max(image, 0.0, image);
  return image;
}

// `find_range()` gives the range of images of more than 8 bits.
template <class FindRange>
std::shared_ptr<GrayImage> LoadGray(const ImageSource& source, const PinholeCamera& camera,
                                    const FindRange& find_range) {
  if (source.is_missing) return std::make_shared<GrayImage>(camera.width, camera.height, 0.0f);
  cv::Mat gray = DecodeOfSize(source.path, cv::IMREAD_GRAYSCALE, source.camera, kOtherPhoto);
  // As float before reducing: 8-bit rounding of the reduced image would add noise of 0.3 grey
  // levels.
  if (gray.depth() == CV_8U) {
    gray.convertTo(gray, CV_32F);
  } else {
    gray = Scaled(gray, find_range());
  }
  return ToRaster<float>(ResizeTo(gray, camera));
}

template <class FindRange>
std::shared_ptr<ColorImage> LoadColors(const ImageSource& source, const PinholeCamera& camera,
                                       const FindRange& find_range) {
  if (source.is_missing) {
    return std::make_shared<ColorImage>(camera.width, camera.height, Color(0, 0, 0));
  }
  cv::Mat image = DecodeOfSize(source.path, cv::IMREAD_COLOR, source.camera, kOtherPhoto);
  if (image.depth() != CV_8U) Scaled(image, find_range()).convertTo(image, CV_8U);
  cv::Mat rgb;
  cv::cvtColor(ResizeTo(image, camera), rgb, cv::COLOR_BGR2RGB);
  return ToRaster<Color>(rgb);
}

// 255 where the image's alpha is not 0; empty if all of it counts.
cv::Mat AlphaMask(const std::string& path) {
  cv::Mat image = Decode(path, cv::IMREAD_UNCHANGED);
  if (image.channels() != 4) return {};
  cv::Mat alpha;
  cv::extractChannel(image, alpha, 3);
  const cv::Mat used = alpha > 0;
  const int num_used = cv::countNonZero(used);
  const bool all = num_used == 0 || num_used == used.rows * used.cols;
  return all ? cv::Mat() : used;
}

cv::Mat UsedPixels(const ImageSource& source) {
  cv::Mat used;
  if (!source.mask_path.empty()) {
    used = DecodeOfSize(source.mask_path, cv::IMREAD_GRAYSCALE, source.camera, kOtherMask) > 0;
  }
  if (!source.alpha_is_mask) return used;
  const cv::Mat opaque = AlphaMask(source.path);
  if (opaque.empty()) return used;
  return used.empty() ? opaque : cv::Mat(used & opaque);
}

std::shared_ptr<ByteImage> LoadMask(const ImageSource& source, const PinholeCamera& camera) {
  if (source.is_missing) return std::make_shared<ByteImage>(camera.width, camera.height, 0);
  const cv::Mat used = UsedPixels(source);
  if (used.empty()) {
    return std::make_shared<ByteImage>(camera.width, camera.height, uint8_t{255});
  }
  // As float: 8 bits would round one ignored pixel of many away.
  cv::Mat ignored;
  cv::Mat(used == 0).convertTo(ignored, CV_32F);
  const cv::Mat reduced = ResizeTo(ignored, camera) == 0;
  return ToRaster<uint8_t>(reduced);
}

// Values of images of more than 8 bits; none if `largest` is 0. A few pixels may be dead: `low` and
// `high` leave out one in a thousand at each end.
struct DeepValues {
  double low = 0, high = 0, largest = 0;
  bool is_float = false;

  void Add(const DeepValues& other) {
    if (!(other.largest > 0)) return;
    low = largest > 0 ? std::min(low, other.low) : other.low;
    high = std::max(high, other.high);
    largest = std::max(largest, other.largest);
    is_float |= other.is_float;
  }
  // What a camera of so many bits, or a program that writes floats, calls white.
  double White() const {
    if (is_float) return std::max(1.0, largest);
    return std::exp2(std::ceil(std::log2(std::max(largest, 255.0) + 1))) - 1;
  }
};

DeepValues MeasureDeepValues(cv::Mat image) {
  DeepValues values;
  values.is_float = image.depth() == CV_32F || image.depth() == CV_64F;
  image.convertTo(image, CV_32F);
  cv::patchNaNs(image);
  cv::minMaxLoc(image, nullptr, &values.largest);
  std::vector<float> sample;
  constexpr size_t kMaxSamples = 100'000;
  const size_t stride = image.total() / kMaxSamples + 1;
  for (size_t i = 0; i < image.total(); i += stride) {
    sample.push_back(image.at<float>(static_cast<int>(i / static_cast<size_t>(image.cols)),
                                     static_cast<int>(i % static_cast<size_t>(image.cols))));
  }
  std::sort(sample.begin(), sample.end());
  const size_t cut = sample.size() / 1000;
  values.low = sample[cut];
  values.high = sample[sample.size() - 1 - cut];
  return values;
}

// Of an image that cannot be read none, which whoever needs its pixels will say.
DeepValues DeepValuesOf(const ImageSource& source) {
  if (source.is_missing) return {};
  try {
    const std::optional<ImageFileInfo> info = InspectImageFile(source.path);
    if (info && info->bits_per_channel <= 8) return {};
    const cv::Mat image = DecodeDeep(source.path, cv::IMREAD_GRAYSCALE);
    return image.depth() == CV_8U ? DeepValues() : MeasureDeepValues(image);
  } catch (const InputError&) {
    return {};
  }
}

enum class Kind { kGray, kColor, kMask };
using Key = std::tuple<int, int, Kind>;

}  // namespace

struct ImageStore::Cache {
  explicit Cache(size_t budget_bytes) : images(budget_bytes) {}

  template <class Image, class Load>
  std::shared_ptr<const Image> Get(const Key& key, const Load& load) {
    const std::shared_ptr<const void> image = images.Get(key, [&] {
      const std::shared_ptr<const Image> loaded = load();
      return Images::Loaded{loaded, loaded->size() * sizeof(loaded->pixels[0])};
    });
    return std::static_pointer_cast<const Image>(image);
  }

  using Images = LruCache<Key, void>;  // a raster of the kind that the key says
  Images images;

  std::once_flag range_is_known;
  DeepRange range;
};

ImageStore::DeepRange ImageStore::FindDeepRange() const {
  std::call_once(cache_->range_is_known, [&] {
    constexpr double kSmallPart = 1.0 / 8, kMargin = 0.05;
    DeepValues values;
    for (const ImageSource& source : sources_) values.Add(DeepValuesOf(source));
    if (!(values.largest > 0)) return;
    cache_->range = {0, values.White()};
    const double spread = values.high - values.low;
    if (!(spread > 0) || spread > kSmallPart * values.White()) return;
    cache_->range = {values.low - kMargin * spread, values.high + kMargin * spread};
  });
  return cache_->range;
}

ImageStore::ImageStore(std::vector<ImageSource> sources, const ImageStoreOptions& options)
    : sources_(std::move(sources)),
      options_(options),
      cache_(std::make_unique<Cache>(options.budget_bytes)) {}

ImageStore::~ImageStore() = default;

PinholeCamera ImageStore::Camera(int view_idx, int level) const {
  LSMVS_CHECK_GE(level, 0);
  return LevelCamera(source(view_idx).camera, options_.max_image_size, level);
}

std::shared_ptr<const GrayImage> ImageStore::Gray(int view_idx, int level) const {
  return cache_->Get<GrayImage>({view_idx, level, Kind::kGray}, [&] {
    return LoadGray(source(view_idx), Camera(view_idx, level), [&] { return FindDeepRange(); });
  });
}

std::shared_ptr<const ColorImage> ImageStore::Colors(int view_idx, int level) const {
  return cache_->Get<ColorImage>({view_idx, level, Kind::kColor}, [&] {
    return LoadColors(source(view_idx), Camera(view_idx, level), [&] { return FindDeepRange(); });
  });
}

std::shared_ptr<const ByteImage> ImageStore::Mask(int view_idx, int level) const {
  const ImageSource& image = source(view_idx);
  if (image.mask_path.empty() && !image.alpha_is_mask && !image.is_missing) return nullptr;
  return cache_->Get<ByteImage>({view_idx, level, Kind::kMask}, [&] {
    return LoadMask(source(view_idx), Camera(view_idx, level));
  });
}

void ImageStore::Trim(size_t max_bytes) const { cache_->images.Trim(max_bytes); }

void ImageStore::SetBudget(size_t budget_bytes) const { cache_->images.SetBudget(budget_bytes); }

size_t ImageStore::HeldBytes() const { return cache_->images.held_bytes(); }

Eigen::Vector2i ReadImageSize(const std::string& path) {
  if (std::filesystem::is_regular_file(path)) {
    if (const std::optional<ImageFileInfo> info = InspectImageFile(path)) return info->size;
  }
  const cv::Mat image = Decode(path, cv::IMREAD_UNCHANGED);
  return {image.cols, image.rows};
}

bool HasAlpha(const std::string& path) {
  const std::optional<ImageFileInfo> info = InspectImageFile(path);
  return info && info->has_alpha;
}

ByteImage ReadAlphaMask(const std::string& path) {
  const cv::Mat mask = AlphaMask(path);
  if (!mask.empty()) return std::move(*ToRaster<uint8_t>(mask));
  const Eigen::Vector2i size = ReadImageSize(path);
  return ByteImage(size.x(), size.y(), uint8_t{255});
}

ByteImage ReadMask(const std::string& path) {
  const cv::Mat used = Decode(path, cv::IMREAD_GRAYSCALE) > 0;
  return std::move(*ToRaster<uint8_t>(used));
}

}  // namespace lsmvs
