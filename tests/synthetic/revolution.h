#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Turns a profile of (radius, height) pairs around the z axis in `num_around` >= 3 steps. The
// profile runs so that the outside lies to its right when radius points right and height up. A
// closed profile (a tube) is joined end to start; an open one must begin and end on the axis
// (radius 0). Closed, manifold, oriented outward.
TriangleMesh Revolve(const std::vector<Eigen::Vector2d>& profile, bool closed_profile,
                     int num_around);

}  // namespace lsmvs
