#pragma once

#include "lsmvs/geometry/inverse_depth_transfer.h"
#include "lsmvs/image/raster.h"

namespace lsmvs {

// A stretch of a row of view i, and what view j shows there through the surface.
struct WarpedRow {
  float* warped;      // grey value of j; 0 where not valid
  float* derivative;  // of `warped` with respect to the depth in i
  float* valid;       // 1 or 0
};

// For the pixels [begin, begin + count) of `row` in view i with depths `depth` (count; 0 = no
// surface): samples view j (`pair` maps i to j) bilinearly where the surface point projects inside
// it and is not hidden there. Hidden is what differs by more than `depth_tolerance` (relative) from
// the interpolated depth map of j, or touches one of its empty pixels.
void WarpRow(const InverseDepthTransfer& pair, const GrayImage& gray_j,
             const Raster<float>& depth_j, float depth_tolerance, int row, int begin, int count,
             const float* depth, const WarpedRow& out);

}  // namespace lsmvs
