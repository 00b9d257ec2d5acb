#pragma once

#include <Eigen/Core>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/scene/depth_map.h"

namespace lsmvs {

// A plane as one pixel sees it: along a row or column of the image the inverse depth of a plane is
// an affine function, so that the plane at another pixel is found with two multiply-adds.
struct Plane {
  float q = 0;   // inverse depth (1 / z) at the pixel's centre, per world unit; 0 where unknown
  float qx = 0;  // its slope per pixel along a row
  float qy = 0;  // ... and along a column

  bool known() const { return q > 0; }
  Plane Moved(float columns, float rows) const { return {q + columns * qx + rows * qy, qx, qy}; }
};

using PlaneMap = Raster<Plane>;

// Plane through a point of depth `depth` on the ray of image coordinates `x_px` with normal
// `normal` (camera frame, towards the camera). Slopes are zero where the normal is zero or at right
// angles to the ray.
Plane PlaneFromDepth(const PinholeCamera& camera, const Eigen::Vector2d& x_px, double depth,
                     const Eigen::Vector3d& normal);
// Unit normal towards the camera, in the camera frame.
Eigen::Vector3f PlaneNormal(const PinholeCamera& camera, const Eigen::Vector2d& x_px,
                            const Plane& plane);

// `camera` has the size of the map.
PlaneMap ToPlaneMap(const PinholeCamera& camera, const DepthMap& map);
DepthMap ToDepthMap(const PinholeCamera& camera, const PlaneMap& planes);

// The planes seen by the pixels of a `width` x `height` image of the same view: each takes the
// plane of the pixel that its centre lies in, moved to its own centre.
PlaneMap ResizePlaneMap(const PlaneMap& planes, int width, int height);

}  // namespace lsmvs
