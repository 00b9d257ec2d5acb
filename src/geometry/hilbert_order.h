#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

// Steps along each axis of the curve, as bits.
inline constexpr int kHilbertBits = 21;

// How far along the curve a cell of 2^kHilbertBits steps an axis lies. Its upper 3 k bits tell the
// same of the coarser cell that has the upper k bits of the steps.
uint64_t HilbertIndex(std::array<uint32_t, 3> step);

// The positions of `points` in the order of a Hilbert curve of 2^21 steps an axis through their
// bounding box: what follows each other in it lies close together. Ties keep their order. O(n); 36
// bytes per point.
std::vector<uint32_t> HilbertOrder(std::span<const Eigen::Vector3f> points);
std::vector<uint32_t> HilbertOrder(std::span<const Eigen::Vector3d> points);

}  // namespace lsmvs
