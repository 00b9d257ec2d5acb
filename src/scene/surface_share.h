#pragma once

#include "lsmvs/scene/scene.h"

namespace lsmvs {

// How much surface the photos show, as far as the sparse points tell: for plans, before there is a
// cloud. Parts of the pixels of all photos.
struct SurfaceShare {
  // Pixels that show surface.
  double covered = 1;
  // Pixels that it takes to show each part of the surface once, in the photo that shows it finest.
  double once = 1.0 / 6;
};

// Each photo is divided into cells. A cell whose middle has a sparse point of the photo within two
// cells lies on the surface, at that point's depth; it counts one over the number of photos that
// have that place in the image and look at it from within 60 degrees of the first. Meshes of real
// runs have what `once` says within a fifth. The defaults where no photo sees a sparse point.
// O(#photos cells) for each photo that is looked at: of more than about 60 photos at least 20.
SurfaceShare EstimateSurfaceShare(const Scene& scene);

}  // namespace lsmvs
