#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// Camera with the principal point in the middle; focal length = `focal_factor` * the longer side.
PinholeCamera MakeCamera(int width, int height, double focal_factor = 1.2);

// Camera at `center` that looks at `target`, with the world's z axis up in the image (y if it looks
// along z).
Rigid3 LookAt(const Eigen::Vector3d& center, const Eigen::Vector3d& target);

// View named "<index, four digits>.png" with image id index + 1.
View MakeView(int index, const PinholeCamera& camera, const Rigid3& cam_from_world);

// `count` cameras on the circle of `radius` around the vertical through `target`, `height` above
// it, that look at `target`; the first at angle `begin_deg` (0 = +x, counter-clockwise), evenly
// over `sweep_deg` (360: a closed ring).
std::vector<Eigen::Vector3d> RingCenters(const Eigen::Vector3d& target, double radius,
                                         double height, int count, double begin_deg = 0,
                                         double sweep_deg = 360);

// `columns` x `rows` centres over [-half_x, half_x] x [-half_y, half_y] at height z, in rows of
// alternating direction as an aeroplane flies.
std::vector<Eigen::Vector3d> GridCenters(double half_x, double half_y, double z, int columns,
                                         int rows);

}  // namespace lsmvs
