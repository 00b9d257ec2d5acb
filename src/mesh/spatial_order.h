#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

// Positions of the points along a Z curve through their bounding cube (2^10 cells a side), points
// of a cell in the order given: what comes close together lies close together. O(n log n).
std::vector<uint32_t> SpatialOrder(std::span<const Eigen::Vector3d> points);

}  // namespace lsmvs
