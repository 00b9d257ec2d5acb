#include "lsmvs/stereo/packed_image.h"

#include <algorithm>
#include <cmath>

namespace lsmvs {

namespace {

// One padded row in units of 1/kScale, one pixel longer than the padded width.
void QuantizeRow(const GrayImage& image, int row, std::vector<int>* line) {
  const float* source = image.Row(std::clamp(row, 0, image.height - 1));
  for (int i = 0; i < static_cast<int>(line->size()); ++i) {
    const float gray = source[std::clamp(i - PackedImage::kPadding, 0, image.width - 1)];
    const float scaled = std::clamp(gray, 0.0f, 255.0f) * PackedImage::kScale;
    (*line)[static_cast<size_t>(i)] = static_cast<int>(scaled + 0.5f);
  }
}

uint64_t Word(int value) { return static_cast<uint16_t>(value); }

}  // namespace

PackedImage::PackedImage(const GrayImage& image)
    : width(image.width), height(image.height), stride(image.width + 2 * kPadding) {
  const int num_rows = height + 2 * kPadding;
  elements.resize(static_cast<size_t>(stride) * static_cast<size_t>(num_rows));
  std::vector<int> top(static_cast<size_t>(stride) + 1), bottom(top.size());
  QuantizeRow(image, -kPadding, &top);
  uint64_t* out = elements.data();
  for (int row = 0; row < num_rows; ++row, out += stride) {
    QuantizeRow(image, row + 1 - kPadding, &bottom);
    for (size_t i = 0; i < static_cast<size_t>(stride); ++i) {
      const int right = top[i + 1] - top[i], down = bottom[i] - top[i];
      out[i] = Word(top[i]) | Word(right) << 16 | Word(down) << 32 |
               Word(bottom[i + 1] - bottom[i] - right) << 48;
    }
    std::swap(top, bottom);
  }
}

}  // namespace lsmvs
