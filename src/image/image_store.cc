#include "lsmvs/image/image_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <list>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "lsmvs/image/image_file.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

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

// With the depth of the file; `flags` say whether in grey or in colours. The decoder of floats
// converts neither to grey nor to colours.
cv::Mat DecodeDeep(const std::string& path, int flags) {
  cv::Mat image = TryDecode(path, flags | cv::IMREAD_ANYDEPTH);
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

// `white()` is the value that becomes 255 in images of more than 8 bits.
template <class White>
std::shared_ptr<GrayImage> LoadGray(const ImageSource& source, const PinholeCamera& camera,
                                    const White& white) {
  if (source.is_missing) return std::make_shared<GrayImage>(camera.width, camera.height, 0.0f);
  const cv::Mat image = DecodeOfSize(source.path, cv::IMREAD_GRAYSCALE, source.camera, kOtherPhoto);
  // As float before reducing: 8-bit rounding of the reduced image would add noise of 0.3 grey
  // levels.
  cv::Mat gray;
  image.convertTo(gray, CV_32F, image.depth() == CV_8U ? 1.0 : 255.0 / white());
  if (image.depth() == CV_32F) cv::patchNaNs(gray);
  return ToRaster<float>(ResizeTo(gray, camera));
}

template <class White>
std::shared_ptr<ColorImage> LoadColors(const ImageSource& source, const PinholeCamera& camera,
                                       const White& white) {
  if (source.is_missing) {
    return std::make_shared<ColorImage>(camera.width, camera.height, Color(0, 0, 0));
  }
  cv::Mat image = DecodeOfSize(source.path, cv::IMREAD_COLOR, source.camera, kOtherPhoto);
  if (image.depth() != CV_8U) image.convertTo(image, CV_8U, 255.0 / white());
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

// Largest value of an image of more than 8 bits; 0 if it has 8 or cannot be read, which whoever
// needs its pixels will say.
double LargestDeepValue(const ImageSource& source) {
  if (source.is_missing) return 0;
  try {
    const std::optional<ImageFileInfo> info = InspectImageFile(source.path);
    if (info && info->bits_per_channel <= 8) return 0;
    cv::Mat image = DecodeDeep(source.path, cv::IMREAD_GRAYSCALE);
    if (image.depth() == CV_8U) return 0;
    if (image.depth() == CV_32F) cv::patchNaNs(image);
    double largest = 0;
    cv::minMaxLoc(image, nullptr, &largest);
    constexpr double kMaxFloatWhite = 1;
    return image.depth() == CV_16U
               ? std::exp2(std::ceil(std::log2(std::max(largest, 255.0) + 1))) - 1
               : std::max(kMaxFloatWhite, largest);
  } catch (const InputError&) {
    return 0;
  }
}

enum class Kind { kGray, kColor, kMask };
using Key = std::tuple<int, int, Kind>;

}  // namespace

// Least-recently-used map from key to decoded image, with one lock an entry so that different
// images are decoded in parallel.
struct ImageStore::Cache {
  struct Entry {
    std::mutex decoding;
    std::shared_ptr<const void> image;
    size_t bytes = 0;
    std::list<Key>::iterator place;
  };

  explicit Cache(size_t budget_bytes) : budget(budget_bytes) {}

  template <class Image, class Load>
  std::shared_ptr<const Image> Get(const Key& key, const Load& load) {
    const std::shared_ptr<Entry> entry = Touch(key);
    const std::lock_guard<std::mutex> decoding(entry->decoding);
    if (!entry->image) {
      std::shared_ptr<const Image> image = load();
      const size_t bytes = image->size() * sizeof(image->pixels[0]);
      entry->image = image;
      Account(key, entry, bytes);
      return image;
    }
    return std::static_pointer_cast<const Image>(entry->image);
  }

  std::shared_ptr<Entry> Touch(const Key& key) {
    const std::lock_guard<std::mutex> lock(mutex);
    std::shared_ptr<Entry>& entry = entries[key];
    if (entry) {
      order.splice(order.begin(), order, entry->place);
    } else {
      entry = std::make_shared<Entry>();
      order.push_front(key);
      entry->place = order.begin();
    }
    return entry;
  }

  void Account(const Key& key, const std::shared_ptr<Entry>& entry, size_t bytes) {
    const std::lock_guard<std::mutex> lock(mutex);
    // Dropped by another thread while it was decoded: the caller keeps the image, the store does
    // not.
    const auto found = entries.find(key);
    if (found == entries.end() || found->second != entry) return;
    entry->bytes = bytes;
    held += bytes;
    while (held > budget && DropOldestBut(key)) {
    }
  }

  void Trim(size_t max_bytes) {
    const std::lock_guard<std::mutex> lock(mutex);
    while (held > max_bytes) DropOldest();
  }

  void DropOldest() { Drop(std::prev(order.end())); }

  // The image given, and those that are still being decoded, may be the oldest themselves where
  // many threads ask for images. False if there is no other.
  bool DropOldestBut(const Key& key) {
    const auto droppable = [&](const Key& other) {
      return other != key && entries.find(other)->second->bytes > 0;
    };
    const auto oldest = std::find_if(order.rbegin(), order.rend(), droppable);
    if (oldest == order.rend()) return false;
    Drop(std::prev(oldest.base()));
    return true;
  }

  void Drop(std::list<Key>::iterator place) {
    const auto entry = entries.find(*place);
    held -= entry->second->bytes;
    entries.erase(entry);
    order.erase(place);
  }

  size_t budget;
  std::mutex mutex;
  std::map<Key, std::shared_ptr<Entry>> entries;
  std::list<Key> order;  // most recently used first
  size_t held = 0;

  std::once_flag white_is_known;
  double white = 255;
};

double ImageStore::White() const {
  std::call_once(cache_->white_is_known, [&] {
    double white = 0;
    for (const ImageSource& source : sources_) white = std::max(white, LargestDeepValue(source));
    if (white > 0) cache_->white = white;
  });
  return cache_->white;
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
    return LoadGray(source(view_idx), Camera(view_idx, level), [&] { return White(); });
  });
}

std::shared_ptr<const ColorImage> ImageStore::Colors(int view_idx, int level) const {
  return cache_->Get<ColorImage>({view_idx, level, Kind::kColor}, [&] {
    return LoadColors(source(view_idx), Camera(view_idx, level), [&] { return White(); });
  });
}

std::shared_ptr<const ByteImage> ImageStore::Mask(int view_idx, int level) const {
  const ImageSource& image = source(view_idx);
  if (image.mask_path.empty() && !image.alpha_is_mask && !image.is_missing) return nullptr;
  return cache_->Get<ByteImage>({view_idx, level, Kind::kMask}, [&] {
    return LoadMask(source(view_idx), Camera(view_idx, level));
  });
}

void ImageStore::Trim(size_t max_bytes) const { cache_->Trim(max_bytes); }

size_t ImageStore::HeldBytes() const {
  const std::lock_guard<std::mutex> lock(cache_->mutex);
  return cache_->held;
}

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
