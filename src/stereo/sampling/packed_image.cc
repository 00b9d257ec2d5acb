#include "lsmvs/stereo/sampling/packed_image.h"

#include <algorithm>

namespace lsmvs {

namespace {

// One padded row, one pixel longer than the padded width.
void RoundRow(const GrayImage& image, int row, std::vector<uint32_t>* line) {
  const float* source = image.Row(std::clamp(row, 0, image.height - 1));
  for (int i = 0; i < static_cast<int>(line->size()); ++i) {
    const float gray = source[std::clamp(i - PackedImage::kPadding, 0, image.width - 1)];
    (*line)[static_cast<size_t>(i)] = static_cast<uint32_t>(std::clamp(gray, 0.0f, 255.0f) + 0.5f);
  }
}

}  // namespace

PackedImage::PackedImage(const GrayImage& image)
    : width(image.width), height(image.height), stride(image.width + 2 * kPadding) {
  const int num_rows = height + 2 * kPadding;
  cells.resize(static_cast<size_t>(stride) * static_cast<size_t>(num_rows));
  std::vector<uint32_t> top(static_cast<size_t>(stride) + 1), bottom(top.size());
  RoundRow(image, -kPadding, &top);
  uint32_t* out = cells.data();
  for (int row = 0; row < num_rows; ++row, out += stride) {
    RoundRow(image, row + 1 - kPadding, &bottom);
    for (size_t i = 0; i < static_cast<size_t>(stride); ++i) {
      out[i] = top[i] | top[i + 1] << 8 | bottom[i] << 16 | bottom[i + 1] << 24;
    }
    std::swap(top, bottom);
  }
}

}  // namespace lsmvs
