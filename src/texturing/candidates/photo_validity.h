#pragma once

#include "lsmvs/geometry/camera.h"
#include "lsmvs/image/raster.h"

namespace lsmvs {

// How far a pixel of a photo can be trusted to show the surface that the depth map has there.
enum PixelValidity : uint8_t {
  kInvalidPixel = 0,
  // Just beside something that is nearer: if that lies a little off, its colour is here.
  kDoubtfulPixel = 1,
  kValidPixel = 2,
};

// A pixel is valid if the surface is there (depth > 0), it lies 4 pixels or more inside of the
// image, is more than 3 pixels away from what `mask` excludes (null: no mask), and does not belong
// to the black rim that undistortion leaves: black pixels that hang together with the rim of the
// image, and those 2 pixels around. It is doubtful within 3 pixels of a depth edge on its far side.
// O(pixels).
Raster<uint8_t> FindValidPixels(const PinholeCamera& camera, const Raster<float>& depth,
                                const ColorImage& colors, const ByteImage* mask);

}  // namespace lsmvs
