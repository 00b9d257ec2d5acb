#pragma once

#include "lsmvs/image/raster.h"

namespace lsmvs {

// Gives the pixels whose `coverage` is 0 the colours around: each level of a pyramid averages what
// is known, and what is unknown takes the colour of the level above. Known pixels stay. Nothing
// happens without known pixels. O(pixels); 4 / 3 bytes a pixel.
//   S. Gortler et al.: The Lumigraph, SIGGRAPH 1996.
void PullPush(const Raster<uint8_t>& coverage, ColorImage* colors);

}  // namespace lsmvs
