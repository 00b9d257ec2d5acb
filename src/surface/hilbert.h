#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace lsmvs {

// The positions of `points` in the order of a Hilbert curve of 2^21 steps an axis through their
// bounding box: what follows each other in it lies close together. Ties keep their order. O(n).
std::vector<uint32_t> HilbertOrder(const std::vector<Eigen::Vector3f>& points);

}  // namespace lsmvs
