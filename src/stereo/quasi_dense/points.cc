#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "lsmvs/stereo/quasi_dense/points.h"

namespace lsmvs::quasi_dense {

namespace {

// Rows of cells that are detected at once, and the rows of pixels around that filters look at.
constexpr size_t kStripRows = 24;
constexpr int kFilterMargin = 10;
// Widths of the difference of Gaussians, pixels: blobs of about 3 pixels, the smallest that repeat.
constexpr double kInnerSigma = 1.0, kOuterSigma = 1.6;
// Responses below this share of the noise are noise: what white noise of sigma 1 leaves in both
// filters is about 0.3.
constexpr float kNoiseShare = 0.6f;

// Harris' response has the dimension of grey^4; its fourth root is comparable to a difference of
// grey values.
float CornerStrength(float harris) { return harris > 0 ? std::sqrt(std::sqrt(harris)) : 0.0f; }

// Strength of each pixel of the rows [first_row, last_row).
Raster<float> Strength(const GrayImage& image, int first_row, int last_row) {
  const int top = std::max(0, first_row - kFilterMargin);
  const int bottom = std::min(image.height, last_row + kFilterMargin);
  const cv::Mat strip(bottom - top, image.width, CV_32F, const_cast<float*>(image.Row(top)));
  cv::Mat harris, inner, outer;
  // cornerHarris scales derivatives by 1 / (4 * block size) for float input: grey levels a pixel
  // averaged over the block, up to a constant.
  cv::cornerHarris(strip, harris, 3, 3, 0.04, cv::BORDER_REFLECT_101);
  cv::GaussianBlur(strip, inner, cv::Size(), kInnerSigma, kInnerSigma, cv::BORDER_REFLECT_101);
  cv::GaussianBlur(strip, outer, cv::Size(), kOuterSigma, kOuterSigma, cv::BORDER_REFLECT_101);
  Raster<float> strength(image.width, last_row - first_row);
  for (int row = first_row; row < last_row; ++row) {
    const float* corner = harris.ptr<float>(row - top);
    const float* a = inner.ptr<float>(row - top);
    const float* b = outer.ptr<float>(row - top);
    float* out = strength.Row(row - first_row);
    for (int column = 0; column < image.width; ++column) {
      out[column] = std::max(CornerStrength(corner[column]), std::abs(a[column] - b[column]));
    }
  }
  return strength;
}

// First pixel of a cell.
int CellBegin(int cell, float spacing) {
  return static_cast<int>(std::ceil(static_cast<float>(cell) * spacing - 0.5f));
}

struct Detector {
  const GrayImage& image;
  const ByteImage* mask;
  const DetectionOptions& options;
  PointGrid* grid;

  bool Usable(int column, int row) const {
    const int border = options.border_px;
    return column >= border && row >= border && column < image.width - border &&
           row < image.height - border && (mask == nullptr || (*mask)(column, row) != 0);
  }

  // The strongest usable pixel of a cell; keeps the first of equals.
  void DetectInCell(int column, int row, const Raster<float>& strength, int first_row) const {
    InterestPoint& point = grid->cells(column, row);
    float best = kNoiseShare * options.noise_sigma;
    const int end_row = std::min(CellBegin(row + 1, grid->spacing), image.height);
    const int end_column = std::min(CellBegin(column + 1, grid->spacing), image.width);
    for (int y = CellBegin(row, grid->spacing); y < end_row; ++y) {
      for (int x = CellBegin(column, grid->spacing); x < end_column; ++x) {
        const float value = strength(x, y - first_row);
        if (value <= best || !Usable(x, y)) continue;
        best = value;
        point.position = {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
        point.score = value;
      }
    }
  }

  void DetectInRows(size_t begin, size_t end) const {
    const int first_row = CellBegin(static_cast<int>(begin), grid->spacing);
    const int last_row = std::min(CellBegin(static_cast<int>(end), grid->spacing), image.height);
    if (first_row >= last_row) return;
    const Raster<float> strength = Strength(image, first_row, last_row);
    for (int row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
      for (int column = 0; column < grid->cells.width; ++column) {
        DetectInCell(column, row, strength, first_row);
      }
    }
  }
};

// Of two points the one that suppresses the other: stronger, or first where equal.
bool Dominates(const InterestPoint& a, const InterestPoint& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.position.y() != b.position.y() ? a.position.y() < b.position.y()
                                          : a.position.x() < b.position.x();
}

// Points that a stronger neighbour is too near to. Judged on the unthinned grid, so that the order
// does not matter.
void Thin(const RunContext& context, PointGrid* grid) {
  const PointGrid& all = *grid;
  Raster<uint8_t> dropped(all.cells.width, all.cells.height, 0);
  const float squared = 0.25f * all.spacing * all.spacing;
  ParallelFor(context, static_cast<size_t>(all.cells.height), kStripRows, [&](size_t row) {
    for (int column = 0; column < all.cells.width; ++column) {
      const InterestPoint& point = all.cells(column, static_cast<int>(row));
      if (!point.exists()) continue;
      ForPointsAround(all, point.position, 1, [&](const InterestPoint& other) {
        if ((other.position - point.position).squaredNorm() < squared && Dominates(other, point)) {
          dropped(column, static_cast<int>(row)) = 1;
        }
      });
    }
  });
  for (size_t i = 0; i < dropped.size(); ++i) {
    grid->cells.pixels[i].score = 0;
    if (dropped.pixels[i] != 0) grid->cells.pixels[i] = InterestPoint();
  }
}

int NumCells(int pixels, float spacing) {
  return std::max(1, static_cast<int>(std::ceil(static_cast<float>(pixels) / spacing)));
}

}  // namespace

PointGrid DetectInterestPoints(const GrayImage& image, const ByteImage* mask,
                               const DetectionOptions& options, const RunContext& context) {
  PointGrid grid;
  grid.spacing = options.spacing_px;
  grid.cells = Raster<InterestPoint>(NumCells(image.width, grid.spacing),
                                     NumCells(image.height, grid.spacing));
  const Detector detector{image, mask, options, &grid};
  ParallelBlocks(context, static_cast<size_t>(grid.cells.height), kStripRows,
                 [&](size_t begin, size_t end) { detector.DetectInRows(begin, end); });
  Thin(context, &grid);
  return grid;
}

size_t JoinKeypoints(std::span<const Eigen::Vector2f> keypoints, const Eigen::Vector2f& scale,
                     const Eigen::Vector2i& size, const ByteImage* mask,
                     const DetectionOptions& options, PointGrid* grid) {
  size_t num_joined = 0;
  Raster<uint8_t> taken(grid->cells.width, grid->cells.height, 0);
  const float border = static_cast<float>(options.border_px);
  const Eigen::Vector2f last = size.cast<float>() - Eigen::Vector2f(border, border);
  for (const Eigen::Vector2f& keypoint : keypoints) {
    const Eigen::Vector2f position = keypoint.cwiseProduct(scale);
    // Written so that NaN is outside.
    if (!((position.array() >= border).all() && (position.array() < last.array()).all())) continue;
    if (mask != nullptr &&
        (*mask)(static_cast<int>(position.x()), static_cast<int>(position.y())) == 0) {
      continue;
    }
    const int column = grid->ColumnOf(position.x()), row = grid->RowOf(position.y());
    if (taken(column, row) != 0) continue;
    taken(column, row) = 1;
    grid->cells(column, row) = InterestPoint();
    grid->cells(column, row).position = position;
    ++num_joined;
  }
  return num_joined;
}

}  // namespace lsmvs::quasi_dense
