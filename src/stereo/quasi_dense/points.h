#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "lsmvs/image/raster.h"
#include "lsmvs/stereo/sampling/plane_map.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs::quasi_dense {

// An interest point of one view on one scale, with its match.
struct InterestPoint {
  Eigen::Vector2f position = {-1,
                              -1};  // image coordinates of the scale; negative: the cell has none
  Plane plane;                      // unknown while there is no match
  float score = 0;                  // mean ZNCC over the best views
  uint32_t slots = 0;  // bit s: the view's neighbour s matches (ZNCC is at least the threshold)

  bool exists() const { return position.x() >= 0; }
  bool matched() const { return plane.known(); }
};

// One interest point a square cell at most.
struct PointGrid {
  float spacing = 1;  // side of a cell, pixels of the scale
  Raster<InterestPoint> cells;

  int ColumnOf(float x) const { return static_cast<int>(x / spacing); }
  int RowOf(float y) const { return static_cast<int>(y / spacing); }
};

// Calls visit(point) for each point that exists in the cells within `reach` cells of the one that
// holds `position`, row by row.
template <class Visit>
void ForPointsAround(const PointGrid& grid, const Eigen::Vector2f& position, int reach,
                     const Visit& visit) {
  const int column = grid.ColumnOf(position.x()), row = grid.RowOf(position.y());
  const int first_row = row > reach ? row - reach : 0;
  const int last_row = row + reach < grid.cells.height ? row + reach : grid.cells.height - 1;
  const int first_column = column > reach ? column - reach : 0;
  const int last_column = column + reach < grid.cells.width ? column + reach : grid.cells.width - 1;
  for (int r = first_row; r <= last_row; ++r) {
    for (int c = first_column; c <= last_column; ++c) {
      if (grid.cells(c, r).exists()) visit(grid.cells(c, r));
    }
  }
}

struct DetectionOptions {
  float spacing_px = 2.5f;
  float noise_sigma = 2;  // grey levels
  int border_px = 4;      // no points nearer to the border: their windows would not fit
};

// The strongest point of each cell: the larger of the Harris corner response and of the absolute
// difference of Gaussians, both in grey levels, if it stands out from the noise. Of two points
// nearer than half the spacing the stronger stays. `mask` may be null. Positions are pixel centres.
// The same for any number of threads.
PointGrid DetectInterestPoints(const GrayImage& image, const ByteImage* mask,
                               const DetectionOptions& options, const RunContext& context);

// Puts keypoints into the grid in place of the points of their cells; of several in a cell the
// first. `keypoints` in full-size image coordinates, times `scale` in those of the grid's image of
// `size` pixels. Returns how many joined: those in the border, masked or not finite do not.
size_t JoinKeypoints(std::span<const Eigen::Vector2f> keypoints, const Eigen::Vector2f& scale,
                     const Eigen::Vector2i& size, const ByteImage* mask,
                     const DetectionOptions& options, PointGrid* grid);

}  // namespace lsmvs::quasi_dense
