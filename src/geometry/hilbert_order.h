#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

// The positions of `points` in the order of a Hilbert curve of 2^21 steps an axis through their
// bounding box: what follows each other in it lies close together. Ties keep their order. O(n); 36
// bytes per point.
std::vector<uint32_t> HilbertOrder(std::span<const Eigen::Vector3f> points);
std::vector<uint32_t> HilbertOrder(std::span<const Eigen::Vector3d> points);

}  // namespace lsmvs
