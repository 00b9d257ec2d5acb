#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace lsmvs {

// A dense width x height array, row by row without padding: element (column, row) is pixels[row *
// width + column].
template <class T>
struct Raster {
  int width = 0, height = 0;
  std::vector<T> pixels;

  Raster() = default;
  Raster(int raster_width, int raster_height)
      : width(raster_width),
        height(raster_height),
        pixels(static_cast<size_t>(raster_width) * static_cast<size_t>(raster_height)) {}
  Raster(int raster_width, int raster_height, const T& value)
      : width(raster_width),
        height(raster_height),
        pixels(static_cast<size_t>(raster_width) * static_cast<size_t>(raster_height), value) {}

  size_t Index(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(width) + static_cast<size_t>(column);
  }
  T& operator()(int column, int row) { return pixels[Index(column, row)]; }
  const T& operator()(int column, int row) const { return pixels[Index(column, row)]; }
  T* Row(int row) { return pixels.data() + Index(0, row); }
  const T* Row(int row) const { return pixels.data() + Index(0, row); }
  bool Inside(int column, int row) const {
    return column >= 0 && row >= 0 && column < width && row < height;
  }
  size_t size() const { return pixels.size(); }
  bool empty() const { return pixels.empty(); }
};

using GrayImage = Raster<float>;             // grey values in [0, 255]
using ByteImage = Raster<uint8_t>;           // masks: 0 = ignore
using Color = Eigen::Matrix<uint8_t, 3, 1>;  // red, green, blue
using ColorImage = Raster<Color>;

}  // namespace lsmvs
