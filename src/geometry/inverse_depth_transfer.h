#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include "lsmvs/geometry/posed_camera.h"

namespace lsmvs {

// How the image coordinates of camera a map to those of camera b: the pixel (u, v) of a at inverse
// depth q lies in b at the homogeneous image coordinates
//   homography (u, v, 1) + q epipole.
// `homography` is that of the plane at infinity, K_b R K_a^-1; `epipole` is the image of a's
// projection centre, K_b t, with R and t of b_from_a. The third coordinate is the depth in b over
// the depth in a. Hartley and Zisserman, Multiple View Geometry, 9.2.2 and 13.
template <class Scalar>
struct InverseDepthTransferOf {
  Eigen::Matrix<Scalar, 3, 3> homography = Eigen::Matrix<Scalar, 3, 3>::Identity();
  Eigen::Matrix<Scalar, 3, 1> epipole = Eigen::Matrix<Scalar, 3, 1>::Zero();

  Eigen::Matrix<Scalar, 3, 1> operator()(const Eigen::Matrix<Scalar, 2, 1>& x_px,
                                         Scalar inverse_depth) const {
    return homography * x_px.homogeneous() + epipole * inverse_depth;
  }
};
using InverseDepthTransfer = InverseDepthTransferOf<double>;
using InverseDepthTransferf = InverseDepthTransferOf<float>;

inline InverseDepthTransfer MakeInverseDepthTransfer(const PinholeCamera& camera_b,
                                                     const PinholeCamera& camera_a,
                                                     const Rigid3& b_from_a) {
  const Eigen::Matrix3d k_b = camera_b.Matrix();
  return {k_b * b_from_a.rotation * camera_a.Matrix().inverse(), k_b * b_from_a.translation};
}

inline InverseDepthTransfer MakeInverseDepthTransfer(const PosedCamera& b, const PosedCamera& a) {
  return MakeInverseDepthTransfer(b.camera, a.camera,
                                  b.cam_from_world * a.cam_from_world.Inverse());
}

}  // namespace lsmvs
