#include "lsmvs/image/hole_filling.h"

#include <algorithm>

namespace lsmvs {

namespace {

// Half the size; a pixel is known if one of its four is, and has their mean colour.
void Pull(const ByteImage& known, const ColorImage& colors, ByteImage* coarse_known,
          ColorImage* mean) {
  *coarse_known = ByteImage((colors.width + 1) / 2, (colors.height + 1) / 2, 0);
  *mean = ColorImage(coarse_known->width, coarse_known->height, Color::Zero());
  for (int row = 0; row < coarse_known->height; ++row) {
    for (int column = 0; column < coarse_known->width; ++column) {
      Eigen::Vector3i sum = Eigen::Vector3i::Zero();
      int count = 0;
      for (int y = 2 * row; y < std::min(2 * row + 2, colors.height); ++y) {
        for (int x = 2 * column; x < std::min(2 * column + 2, colors.width); ++x) {
          if (known(x, y) == 0) continue;
          sum += colors(x, y).cast<int>();
          ++count;
        }
      }
      if (count == 0) continue;
      (*coarse_known)(column, row) = 1;
      (*mean)(column, row) = ((2 * sum.array() + count) / (2 * count)).cast<uint8_t>().matrix();
    }
  }
}

}  // namespace

void FillHoles(const ByteImage& known, ColorImage* image) {
  if (image->width <= 1 && image->height <= 1) return;
  ByteImage coarse_known;
  ColorImage mean;
  Pull(known, *image, &coarse_known, &mean);
  FillHoles(coarse_known, &mean);
  for (int row = 0; row < image->height; ++row) {
    for (int column = 0; column < image->width; ++column) {
      if (known(column, row) == 0) (*image)(column, row) = mean(column / 2, row / 2);
    }
  }
}

}  // namespace lsmvs
