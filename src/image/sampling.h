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

}  // namespace lsmvs
