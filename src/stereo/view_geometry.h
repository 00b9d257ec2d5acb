#pragma once

#include <Eigen/Core>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"

namespace lsmvs {

// How image coordinates of one view map to another's: homogeneous coordinates in b of (u, v) in a
// at inverse depth q are m (u, v, 1) + q e. Their third entry is the depth in b over the depth in
// a.
struct ViewGeometry {
  Eigen::Matrix3d m;
  Eigen::Vector3d e;
};

inline ViewGeometry BFromA(const PinholeCamera& camera_b, const PinholeCamera& camera_a,
                           const Rigid3& b_from_a) {
  const Eigen::Matrix3d k_b = camera_b.Matrix();
  return {k_b * b_from_a.rotation * camera_a.Matrix().inverse(), k_b * b_from_a.translation};
}

}  // namespace lsmvs
