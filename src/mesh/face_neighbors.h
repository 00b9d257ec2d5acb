#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

// The face across each side of a face: entry k is that of the edge from corner k to corner k + 1;
// -1 at the border and where more than two faces meet.
using FaceNeighbors = std::vector<std::array<int32_t, 3>>;  // #F

// O(#V + #F); 48 bytes per face of scratch.
FaceNeighbors FindFaceNeighbors(std::span<const Eigen::Vector3i> faces, size_t num_vertices);

}  // namespace lsmvs
