#pragma once

#include <algorithm>
#include <cstddef>

#include "lsmvs/image/image_store.h"

namespace lsmvs {

// Pixels of the store's largest image at a level: what caches of a number of views are sized by.
inline size_t LargestImagePixels(const ImageStore& images, int level = 0) {
  size_t num_pixels = 0;
  for (size_t v = 0; v < images.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(static_cast<int>(v), level);
    num_pixels = std::max(num_pixels, static_cast<size_t>(camera.width) * camera.height);
  }
  return num_pixels;
}

// Views that caches hold at most: those that one view has to do with. More would make memory grow
// with the number of photos and save little time.
inline constexpr size_t kViewsHeld = 12;

// Lets go of all but about the photos of so many views.
inline void TrimToViewsHeld(const ImageStore& images) {
  constexpr size_t kBytesPerPixel = 6;  // of a photo with all its levels in grey
  images.Trim(kViewsHeld * kBytesPerPixel * LargestImagePixels(images));
}

}  // namespace lsmvs
