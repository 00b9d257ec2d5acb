#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// An image laid out so that one 64-bit load brings all that a bilinear sample takes. Element (x, y)
// holds four signed 16-bit numbers, lowest first, in units of 1/kScale grey level: with p(i, j) the
// pixel (x + i, y + j),
//   p(0,0)    p(1,0) - p(0,0)    p(0,1) - p(0,0)    p(1,1) - p(1,0) - p(0,1) + p(0,0)
// so that the sample at (x + a, y + b) is n0 + a n1 + b (n2 + a n3).
// Padded by kPadding repeated pixels on every side, so that a sample a little outside is safe. 8
// bytes a pixel.
struct PackedImage {
  static constexpr int kPadding = 8;
  static constexpr float kScale = 64.0f;

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
