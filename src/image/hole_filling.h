#pragma once

#include "lsmvs/image/raster.h"

namespace lsmvs {

// Gives each pixel that is not `known` (0) a smooth continuation of those that are: the mean of the
// known pixels of the finest power-of-two block around it that has any (pull-push, Gortler et al.,
// SIGGRAPH 1996, without blending). Known pixels stay. Without any, all becomes black. O(pixels);
// memory: 4 / 3 bytes per pixel.
void FillHoles(const ByteImage& known, ColorImage* image);

}  // namespace lsmvs
