#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// A grey image of 8 bits laid out so that one 32-bit load brings all that a bilinear sample takes:
// cell (x, y) holds the pixels (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1), the first in the
// lowest byte. Grey values are rounded to whole ones (0.3 of noise, far below that of a sensor).
// Padded by kPadding repeated pixels on every side, so that a sample a little outside is safe. 4
// bytes a pixel, as GrayImage. Samples: packed_sampler-inl.h.
struct PackedImage {
  static constexpr int kPadding = 8;

  int width = 0, height = 0;  // of the image, without padding
  int stride = 0;             // cells a row
  std::vector<uint32_t> cells;

  PackedImage() = default;
  explicit PackedImage(const GrayImage& image);

  size_t bytes() const { return cells.size() * sizeof(uint32_t); }
  // Cell of pixel (0, 0).
  const uint32_t* Origin() const {
    return cells.data() + static_cast<size_t>(kPadding) * static_cast<size_t>(stride) + kPadding;
  }
};

}  // namespace lsmvs
