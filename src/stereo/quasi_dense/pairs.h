#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/geometry/inverse_depth_transfer.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/stereo/quasi_dense/points.h"
#include "lsmvs/stereo/quasi_dense/window.h"

namespace lsmvs::quasi_dense {

// From `from` to `to`, whose images have the cameras given, in single precision.
InverseDepthTransferf MakePairTransfer(const Rigid3& from_pose, const PinholeCamera& from_camera,
                                       const Rigid3& to_pose, const PinholeCamera& to_camera);

// First-order warp of the window around a point of a plane, and how fast it moves with inverse
// depth.
struct PlaneWarp {
  WindowWarp warp;
  Eigen::Vector2f velocity = Eigen::Vector2f::Zero();  // pixels per unit of inverse depth
};
// False if the point lies behind the other camera.
bool WarpPlane(const InverseDepthTransferf& geometry, const Eigen::Vector2f& position,
               const Plane& plane, PlaneWarp* result);

// A view and the one it is matched with, both ways.
struct Pairing {
  int view_idx = -1;
  InverseDepthTransferf there, back;
};

// Neighbours of each view, best first, cut to `max_num_neighbors`, then those that only the other
// side chose: j is a neighbour of i if and only if i is one of j. 32 at most. Unusable entries
// (itself, out of range, twice) are skipped.
std::vector<std::vector<int>> SymmetricNeighbors(
    const std::vector<std::vector<Neighbor>>& neighbors, int max_num_neighbors);

// Geometry of a view with its neighbours on one level of the images.
std::vector<Pairing> MakePairings(const Scene& scene, const ImageStore& images, int level,
                                  int view_idx, const std::vector<int>& neighbors);

}  // namespace lsmvs::quasi_dense
