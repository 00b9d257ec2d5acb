#include "lsmvs/texturing/candidates/photo_validity.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace lsmvs {

namespace {

constexpr int kBorder = 4;
constexpr int kMaskMargin = 3;
constexpr int kRimMargin = 2;
constexpr int kEdgeMargin = 3;
// A step of depth from pixel to pixel that is larger than this many pixels' widths on the surface
// is an edge; a plane seen at 80 degrees has 5.7.
constexpr float kSteepestStep = 6;

using Pixels = std::vector<Eigen::Vector2i>;

bool IsBlack(const Color& color) { return color[0] == 0 && color[1] == 0 && color[2] == 0; }

// Black pixels that hang together with the rim of the image: 255.
ByteImage FindBlackRim(const ColorImage& colors, bool* any) {
  ByteImage rim(colors.width, colors.height, uint8_t{0});
  Pixels open;
  const auto visit = [&](int column, int row) {
    if (!colors.Inside(column, row) || rim(column, row) != 0) return;
    if (!IsBlack(colors(column, row))) return;
    rim(column, row) = 255;
    open.emplace_back(column, row);
  };
  for (int x = 0; x < colors.width; ++x) {
    visit(x, 0);
    visit(x, colors.height - 1);
  }
  for (int y = 0; y < colors.height; ++y) {
    visit(0, y);
    visit(colors.width - 1, y);
  }
  *any = !open.empty();
  while (!open.empty()) {
    const Eigen::Vector2i p = open.back();
    open.pop_back();
    visit(p.x() - 1, p.y());
    visit(p.x() + 1, p.y());
    visit(p.x(), p.y() - 1);
    visit(p.x(), p.y() + 1);
  }
  return rim;
}

// Makes invalid what lies within `margin` pixels of where `bad(pixel)` of the image holds.
template <class Bad>
void ExcludeAround(const ByteImage& image, int margin, const Bad& bad, Raster<uint8_t>* validity) {
  cv::Mat excluded(image.height, image.width, CV_8U), wider;
  for (int row = 0; row < image.height; ++row) {
    std::transform(image.Row(row), image.Row(row) + image.width, excluded.ptr<uint8_t>(row),
                   [&](uint8_t value) { return bad(value) ? 255 : 0; });
  }
  const int side = 2 * margin + 1;
  cv::dilate(excluded, wider, cv::Mat::ones(side, side, CV_8U));
  for (int row = 0; row < image.height; ++row) {
    const uint8_t* flags = wider.ptr<uint8_t>(row);
    uint8_t* out = validity->Row(row);
    for (int column = 0; column < image.width; ++column) {
      if (flags[column] != 0) out[column] = kInvalidPixel;
    }
  }
}

// What lies behind the edge at (column, row), where the surface in front has depth `z`.
void DoubtBehind(const Raster<float>& depth, int column, int row, float relative_step,
                 Raster<uint8_t>* validity) {
  const float behind = depth(column, row) * (1 + relative_step);
  const int right = std::min(depth.width - 1, column + kEdgeMargin);
  const int bottom = std::min(depth.height - 1, row + kEdgeMargin);
  for (int y = std::max(0, row - kEdgeMargin); y <= bottom; ++y) {
    for (int x = std::max(0, column - kEdgeMargin); x <= right; ++x) {
      if (depth(x, y) <= behind) continue;
      (*validity)(x, y) = std::min<uint8_t>((*validity)(x, y), kDoubtfulPixel);
    }
  }
}

void DoubtFarSidesOfEdges(const Raster<float>& depth, float relative_step,
                          Raster<uint8_t>* validity) {
  const auto look = [&](int column, int row, int other_column, int other_row) {
    const float z = depth(column, row), other = depth(other_column, other_row);
    if (!(z > 0) || !(other > 0)) return;
    if (other > z * (1 + relative_step)) DoubtBehind(depth, column, row, relative_step, validity);
    if (z > other * (1 + relative_step)) {
      DoubtBehind(depth, other_column, other_row, relative_step, validity);
    }
  };
  for (int row = 0; row < depth.height; ++row) {
    for (int column = 0; column < depth.width; ++column) {
      if (column + 1 < depth.width) look(column, row, column + 1, row);
      if (row + 1 < depth.height) look(column, row, column, row + 1);
    }
  }
}

}  // namespace

Raster<uint8_t> FindValidPixels(const PinholeCamera& camera, const Raster<float>& depth,
                                const ColorImage& colors, const ByteImage* mask) {
  Raster<uint8_t> validity(depth.width, depth.height, uint8_t{kInvalidPixel});
  for (int row = kBorder; row < depth.height - kBorder; ++row) {
    for (int column = kBorder; column < depth.width - kBorder; ++column) {
      if (depth(column, row) > 0) validity(column, row) = kValidPixel;
    }
  }
  const float step = kSteepestStep / static_cast<float>(camera.MeanFocalLength());
  DoubtFarSidesOfEdges(depth, step, &validity);
  if (mask != nullptr) {
    ExcludeAround(
        *mask, kMaskMargin, [](uint8_t value) { return value == 0; }, &validity);
  }
  bool any = false;
  const ByteImage rim = FindBlackRim(colors, &any);
  if (any)
    ExcludeAround(
        rim, kRimMargin, [](uint8_t value) { return value != 0; }, &validity);
  return validity;
}

}  // namespace lsmvs
