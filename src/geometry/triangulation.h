#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace lsmvs {

// Angle in radians at x between the directions to two projection centres, in [0, pi].
double TriangulationAngle(const Eigen::Vector3d& center_a, const Eigen::Vector3d& center_b,
                          const Eigen::Vector3d& x);

// Ray from a projection centre; `direction` of unit length.
struct ViewingRay {
  Eigen::Vector3d origin, direction;
};

// Point that minimises the sum of squared distances to the rays (midpoint method for two). Empty if
// the rays are (nearly) parallel. Needs at least two rays.
std::optional<Eigen::Vector3d> TriangulateRays(const std::vector<ViewingRay>& rays);

}  // namespace lsmvs
