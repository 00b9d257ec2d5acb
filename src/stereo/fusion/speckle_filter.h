#pragma once

#include <cstdint>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// What speaks for a pixel of a depth map.
enum PixelSupport : uint8_t {
  kNoSupport,
  kWeakSupport,  // nearly views enough, in close agreement
  kSupported,    // views enough
  kCovered,      // a lower view that agrees has a point there
};

// Resets pixels of kWeakSupport to kNoSupport where they do not hang together: where their
// connected component has less than `min_area` pixels. Components are over pixels with any support;
// pixels up to two apart are joined where depths differ by at most `max_depth_step` of the depth.
// O(pixels), 5 bytes per pixel.
void FilterSpeckles(const Raster<float>& depths, double max_depth_step, int min_area,
                    Raster<uint8_t>* support);

}  // namespace lsmvs
