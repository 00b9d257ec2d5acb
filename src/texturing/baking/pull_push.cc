#include "lsmvs/texturing/baking/pull_push.h"

#include <algorithm>

namespace lsmvs {

namespace {

// Half the size; a pixel is known if one of its four is, and has their mean colour.
void Pull(const Raster<uint8_t>& coverage, const ColorImage& colors, Raster<uint8_t>* known,
          ColorImage* mean) {
  *known = Raster<uint8_t>((colors.width + 1) / 2, (colors.height + 1) / 2, uint8_t{0});
  *mean = ColorImage(known->width, known->height, Color::Zero());
  for (int row = 0; row < known->height; ++row) {
    for (int column = 0; column < known->width; ++column) {
      Eigen::Vector3i sum = Eigen::Vector3i::Zero();
      int count = 0;
      for (int y = 2 * row; y < std::min(2 * row + 2, colors.height); ++y) {
        for (int x = 2 * column; x < std::min(2 * column + 2, colors.width); ++x) {
          if (coverage(x, y) == 0) continue;
          sum += colors(x, y).cast<int>();
          ++count;
        }
      }
      if (count == 0) continue;
      (*known)(column, row) = 1;
      (*mean)(column, row) = ((2 * sum.array() + count) / (2 * count)).cast<uint8_t>().matrix();
    }
  }
}

}  // namespace

void PullPush(const Raster<uint8_t>& coverage, ColorImage* colors) {
  if (colors->width <= 1 && colors->height <= 1) return;
  Raster<uint8_t> known;
  ColorImage mean;
  Pull(coverage, *colors, &known, &mean);
  PullPush(known, &mean);
  for (int row = 0; row < colors->height; ++row) {
    for (int column = 0; column < colors->width; ++column) {
      if (coverage(column, row) == 0) (*colors)(column, row) = mean(column / 2, row / 2);
    }
  }
}

}  // namespace lsmvs
