#pragma once

#include <cstddef>
#include <cstdint>

#include "lsmvs/image/raster.h"
#include "lsmvs/stereo/sampling/plane_map.h"

namespace lsmvs {

// Where the photo has no texture above its noise, a pixel's depth does not come from the pixel: a
// matching window that reaches over a silhouette carries the depth of what stands there out into
// the plain sky, and a coarser level fills in the rest. Between pixels that have texture such a
// depth is an interpolation and completes a plain wall; beyond them it is an extrapolation, and a
// rim of sky hangs on every roof.

// 1 where the grey variance of the (2 radius + 1)^2 pixels around exceeds `min_variance` (grey
// levels squared), 0 elsewhere.
Raster<uint8_t> TexturedPixels(const GrayImage& gray, int radius, float min_variance);

struct TexturelessFilterOptions {
  float max_deviation = 0;  // inverse depth by which a plain zone may bulge out of its rim's chord
  float max_step = 0;       // inverse depth between neighbours that hang together
  int border_reach = 0;     // pixels to the image's border within which texture may lie beyond it
  int texture_radius = 0;   // of the windows that TexturedPixels looked at
};

// Resets the planes (q = 0) of pixels without texture that are not between textured ones. A pixel
// is kept if along a row, a column or a diagonal its depth continues or interpolates that of
// textured pixels on both sides, or of one side where the image ends on the other.
// Returns how many were reset. O(pixels), 24 bytes per pixel.
size_t FilterTexturelessPixels(const Raster<uint8_t>& textured,
                               const TexturelessFilterOptions& settings, PlaneMap* planes);

}  // namespace lsmvs
