#pragma once

#include <Eigen/Core>

#include "lsmvs/image/raster.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// One view at one pyramid level.
struct LevelView {
  PinholeCamera camera;  // of the level
  Rigid3 cam_from_world;
};

// How points along the viewing rays of view i project into view j: a pixel of i with ray r (z = 1)
// and depth d lies at d * (rotation * r) + translation in homogeneous image coordinates of j.
struct PairGeometry {
  Eigen::Matrix3d rotation;     // K_j R_j R_i^T K_i^-1: takes image coordinates of i
  Eigen::Vector3d translation;  // K_j (t_j - R_j R_i^T t_i); its z is in world units
};

PairGeometry MakePairGeometry(const LevelView& i, const LevelView& j);

// A stretch of a row of view i, and what view j shows there through the surface.
struct WarpedRow {
  float* warped;      // grey value of j; 0 where not valid
  float* derivative;  // of `warped` with respect to the depth in i
  float* valid;       // 1 or 0
};

// For the pixels [begin, begin + count) of `row` in view i with depths `depth` (count; 0 = no
// surface): samples view j bilinearly where the surface point projects inside it and is not hidden
// there. Hidden is what differs by more than `depth_tolerance` (relative) from the interpolated
// depth map of j, or touches one of its empty pixels.
void WarpRow(const PairGeometry& pair, const GrayImage& gray_j, const Raster<float>& depth_j,
             float depth_tolerance, int row, int begin, int count, const float* depth,
             const WarpedRow& out);

}  // namespace lsmvs
