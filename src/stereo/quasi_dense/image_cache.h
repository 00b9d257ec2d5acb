#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "lsmvs/image/image_store.h"
#include "lsmvs/stereo/quasi_dense/window.h"
#include "lsmvs/util/lru_cache.h"

namespace lsmvs::quasi_dense {

// Packed images of the store's views, the most recently used ones within a budget. Thread-safe.
class PackedImageCache {
 public:
  PackedImageCache(const ImageStore& images, size_t budget_bytes)
      : images_(images), packed_(budget_bytes) {}

  std::shared_ptr<const PackedImage> Get(int view_idx, int level) {
    return packed_.Get({view_idx, level}, [&] {
      auto image = std::make_shared<const PackedImage>(*images_.Gray(view_idx, level));
      return Packed::Loaded{image, image->bytes()};
    });
  }

 private:
  using Packed = LruCache<std::pair<int, int>, PackedImage>;  // view, level

  const ImageStore& images_;
  Packed packed_;
};

}  // namespace lsmvs::quasi_dense
