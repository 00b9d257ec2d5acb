#pragma once

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"

namespace lsmvs {

// A camera with its pose, for an image of camera.width x camera.height pixels: a view at one level
// of its pyramid, or the place that a picture is drawn from.
struct PosedCamera {
  PinholeCamera camera;
  Rigid3 cam_from_world;
};

}  // namespace lsmvs
