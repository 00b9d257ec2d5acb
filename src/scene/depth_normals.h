#pragma once

#include <Eigen/Core>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/image/raster.h"

namespace lsmvs {

// Normals of a depth map (z in the camera frame; not positive: none), for maps that come without.
// Each is that of the plane fitted to the inverse depths of the 5 x 5 samples around, as far as
// they lie within 2 % of the middle one: inverse depth is linear over the image of a plane. Unit
// length, camera frame, towards the camera; zero where the depth is missing or fewer than six
// samples fit.
//   camera     of the map's size
//   sample_px  where in its pixel a sample lies: 0.5 is the middle, 0 the top left corner
// O(25 pixels).
Raster<Eigen::Vector3f> NormalsFromDepth(const Raster<float>& depth, const PinholeCamera& camera,
                                         double sample_px);

}  // namespace lsmvs
