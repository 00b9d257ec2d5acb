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

cv::Mat Decode(const std::string& path, int flags) {
  if (!std::filesystem::is_regular_file(path)) {
    throw InputError(path, "image file is missing", "put it back or remove it from the model");
  }
  InspectImageFile(path);  // throws if it is cut off, which imread would not
  cv::Mat image;
  try {
    image = cv::imread(path, flags);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) throw InputError(path, "cannot be decoded as an image", kReexport);
  return image;
}

cv::Mat DecodeOfSize(const std::string& path, int flags, const PinholeCamera& camera,
                     const char* remedy) {
  cv::Mat image = Decode(path, flags | cv::IMREAD_IGNORE_ORIENTATION);
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

std::shared_ptr<GrayImage> LoadGray(const ImageSource& source, const PinholeCamera& camera) {
  // As float before reducing: 8-bit rounding of the reduced image would add noise of 0.3 grey
  // levels.
  cv::Mat gray;
  DecodeOfSize(source.path, cv::IMREAD_GRAYSCALE, source.camera, kOtherPhoto)
      .convertTo(gray, CV_32F);
  return ToRaster<float>(ResizeTo(gray, camera));
}

std::shared_ptr<ColorImage> LoadColors(const ImageSource& source, const PinholeCamera& camera) {
  const cv::Mat image = DecodeOfSize(source.path, cv::IMREAD_COLOR, source.camera, kOtherPhoto);
  cv::Mat rgb;
  cv::cvtColor(ResizeTo(image, camera), rgb, cv::COLOR_BGR2RGB);
  return ToRaster<Color>(rgb);
}

std::shared_ptr<ByteImage> LoadMask(const ImageSource& source, const PinholeCamera& camera) {
  const cv::Mat mask =
      DecodeOfSize(source.mask_path, cv::IMREAD_GRAYSCALE, source.camera, kOtherMask);
  // As float: 8 bits would round one ignored pixel of many away.
  cv::Mat ignored;
  cv::Mat(mask == 0).convertTo(ignored, CV_32F);
  const cv::Mat reduced = ResizeTo(ignored, camera) == 0;
  return ToRaster<uint8_t>(reduced);
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
};

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
    return LoadGray(source(view_idx), Camera(view_idx, level));
  });
}

std::shared_ptr<const ColorImage> ImageStore::Colors(int view_idx, int level) const {
  return cache_->Get<ColorImage>({view_idx, level, Kind::kColor}, [&] {
    return LoadColors(source(view_idx), Camera(view_idx, level));
  });
}

std::shared_ptr<const ByteImage> ImageStore::Mask(int view_idx, int level) const {
  if (source(view_idx).mask_path.empty()) return nullptr;
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
    if (const std::optional<Eigen::Vector2i> size = InspectImageFile(path)) return *size;
  }
  const cv::Mat image = Decode(path, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  return {image.cols, image.rows};
}

}  // namespace lsmvs
