#pragma once

#include "lsmvs/image/raster.h"

namespace lsmvs {

// Mean over the (2 radius + 1)^2 window around each pixel; beyond the border the image goes on
// mirrored, the border pixel itself repeated. `radius` is less than both sides of the image.
// O(pixels) for any radius. `scratch` and `mean` are resized as needed; `mean` may not be `image`.
void BoxMean(const GrayImage& image, int radius, GrayImage* scratch, GrayImage* mean);

}  // namespace lsmvs
