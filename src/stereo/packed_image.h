#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// An image laid out so that one 64-bit load brings the four pixels of a bilinear sample: element
// (x, y) holds pixels (x,y), (x+1,y), (x,y+1), (x+1,y+1) in 16 bits each, lowest first, in units of
// 1/kScale grey level. Padded by kPadding repeated pixels on every side, so that a sample a little
// outside is safe. 8 bytes a pixel.
struct PackedImage {
  static constexpr int kPadding = 8;
  static constexpr float kScale = 128.0f;

  int width = 0, height = 0;  // of the image, without padding
  int stride = 0;             // elements a row
  std::vector<uint64_t> elements;

  PackedImage() = default;
  explicit PackedImage(const GrayImage& image);

  // Element of pixel (0, 0).
  const uint64_t* Origin() const {
    return elements.data() + static_cast<size_t>(kPadding) * static_cast<size_t>(stride) + kPadding;
  }
};

}  // namespace lsmvs
