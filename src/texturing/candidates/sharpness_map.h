#pragma once

#include <cstdint>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// How sharp a photo is, place by place: the sum of the absolute Laplacian between neighbouring
// pixels, over the same between pixels twice as far apart, in windows of about 48 pixels. About 1
// for noise, 0.25 for what is smooth over some pixels; does not depend on contrast or exposure.
class SharpnessMap {
 public:
  // O(pixels).
  explicit SharpnessMap(const ColorImage& colors);

  // In 1 .. 255, 128 for a ratio of 1.
  uint8_t At(int column, int row) const { return blocks_(column / kBlockSize, row / kBlockSize); }

 private:
  static constexpr int kBlockSize = 16;
  Raster<uint8_t> blocks_;
};

}  // namespace lsmvs
