#include "lsmvs/evaluation/photos/box_filter.h"

#include <vector>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

int Mirror(int i, int size) {
  if (i < 0) return -1 - i;
  return i < size ? i : 2 * size - 1 - i;
}

void ResizeTo(const GrayImage& image, GrayImage* target) {
  if (target->width != image.width || target->height != image.height) {
    *target = GrayImage(image.width, image.height);
  }
}

// Means along one row, by a running sum.
void RowMeans(const float* row, int width, int radius, float* means) {
  double sum = 0;
  for (int i = -radius; i < radius; ++i) sum += row[Mirror(i, width)];
  const double scale = 1.0 / (2 * radius + 1);
  for (int x = 0; x < width; ++x) {
    sum += row[Mirror(x + radius, width)];
    means[x] = static_cast<float>(sum * scale);
    sum -= row[Mirror(x - radius, width)];
  }
}

}  // namespace

void BoxMean(const GrayImage& image, int radius, GrayImage* scratch, GrayImage* mean) {
  LSMVS_CHECK(radius >= 0 && radius < image.width && radius < image.height);
  ResizeTo(image, scratch);
  ResizeTo(image, mean);
  const int width = image.width, height = image.height;
  for (int y = 0; y < height; ++y) RowMeans(image.Row(y), width, radius, scratch->Row(y));

  std::vector<double> sums(static_cast<size_t>(width), 0.0);
  const auto add = [&](int y, double sign) {
    const float* row = scratch->Row(Mirror(y, height));
    for (int x = 0; x < width; ++x) sums[x] += sign * row[x];
  };
  for (int y = -radius; y < radius; ++y) add(y, 1);
  const double scale = 1.0 / (2 * radius + 1);
  for (int y = 0; y < height; ++y) {
    add(y + radius, 1);
    for (int x = 0; x < width; ++x) mean->Row(y)[x] = static_cast<float>(sums[x] * scale);
    add(y - radius, -1);
  }
}

}  // namespace lsmvs
