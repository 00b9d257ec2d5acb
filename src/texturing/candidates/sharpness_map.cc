#include "lsmvs/texturing/candidates/sharpness_map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace lsmvs {

namespace {

struct Sums {
  double fine = 0, coarse = 0;
};

int Laplacian(const ColorImage& colors, int column, int row, int step) {
  const auto green = [&](int x, int y) { return static_cast<int>(colors(x, y)[1]); };
  return std::abs(4 * green(column, row) - green(column - step, row) - green(column + step, row) -
                  green(column, row - step) - green(column, row + step));
}

// Sums over the neighbouring blocks, too.
Sums Around(const Raster<Sums>& blocks, int column, int row) {
  Sums sums;
  for (int y = std::max(0, row - 1); y <= std::min(blocks.height - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(blocks.width - 1, column + 1); ++x) {
      sums.fine += blocks(x, y).fine;
      sums.coarse += blocks(x, y).coarse;
    }
  }
  return sums;
}

}  // namespace

SharpnessMap::SharpnessMap(const ColorImage& colors) {
  constexpr int kMargin = 2;
  constexpr double kUnit = 128;
  const int columns = (colors.width + kBlockSize - 1) / kBlockSize;
  const int rows = (colors.height + kBlockSize - 1) / kBlockSize;
  Raster<Sums> sums(columns, rows);
  for (int row = kMargin; row < colors.height - kMargin; ++row) {
    for (int column = kMargin; column < colors.width - kMargin; ++column) {
      Sums& block = sums(column / kBlockSize, row / kBlockSize);
      block.fine += Laplacian(colors, column, row, 1);
      block.coarse += Laplacian(colors, column, row, 2);
    }
  }
  blocks_ = Raster<uint8_t>(columns, rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Sums around = Around(sums, column, row);
      const double ratio = around.coarse > 0 ? around.fine / around.coarse : 1.0;
      blocks_(column, row) = static_cast<uint8_t>(std::clamp(std::lround(kUnit * ratio), 1l, 255l));
    }
  }
}

}  // namespace lsmvs
