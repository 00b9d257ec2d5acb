#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// Value and derivative of the bilinear interpolant at image coordinates (x, y) (centre of the first
// pixel at (0.5, 0.5)).
struct BilinearSample {
  float value = 0;
  Eigen::Vector2f gradient =
      Eigen::Vector2f::Zero();  // per pixel; exact derivative of `value` inside a cell
};

// Whether a bilinear sample at (x, y) needs no pixel outside the image.
template <class T>
bool InsideForSampling(const Raster<T>& image, double x, double y) {
  return x >= 0.5 && y >= 0.5 && x <= image.width - 0.5 && y <= image.height - 0.5;
}

// The caller checks InsideForSampling first. The image must be at least 2 x 2.
inline BilinearSample SampleBilinear(const GrayImage& image, double x, double y) {
  const double px = x - 0.5, py = y - 0.5;
  const int column = std::clamp(static_cast<int>(px), 0, image.width - 2);
  const int row = std::clamp(static_cast<int>(py), 0, image.height - 2);
  const float a = static_cast<float>(px - column), b = static_cast<float>(py - row);
  const float* top = image.Row(row) + column;
  const float* bottom = top + image.width;
  const float top_step = top[1] - top[0], bottom_step = bottom[1] - bottom[0];
  const float top_value = top[0] + a * top_step, bottom_value = bottom[0] + a * bottom_step;
  BilinearSample sample;
  sample.value = top_value + b * (bottom_value - top_value);
  sample.gradient = {top_step + b * (bottom_step - top_step), bottom_value - top_value};
  return sample;
}

// Colour of the bilinear interpolant at (x, y), in grey levels; outside of the pixels' centres that
// of the nearest point inside. At the centre of a pixel it is the pixel, exactly.
inline Eigen::Vector3f SampleColors(const ColorImage& image, double x, double y) {
  const double px = std::clamp(x - 0.5, 0.0, image.width - 1.0);
  const double py = std::clamp(y - 0.5, 0.0, image.height - 1.0);
  const int column = std::min(static_cast<int>(px), std::max(0, image.width - 2));
  const int row = std::min(static_cast<int>(py), std::max(0, image.height - 2));
  const int right = std::min(column + 1, image.width - 1);
  const int below = std::min(row + 1, image.height - 1);
  const float a = static_cast<float>(px - column), b = static_cast<float>(py - row);
  const Eigen::Vector3f top =
      (1 - a) * image(column, row).cast<float>() + a * image(right, row).cast<float>();
  const Eigen::Vector3f bottom =
      (1 - a) * image(column, below).cast<float>() + a * image(right, below).cast<float>();
  return (1 - b) * top + b * bottom;
}

// Nearest colour of grey levels.
inline Color RoundColor(const Eigen::Vector3f& levels) {
  return levels.array().max(0.0f).min(255.0f).round().cast<uint8_t>().matrix();
}

}  // namespace lsmvs
