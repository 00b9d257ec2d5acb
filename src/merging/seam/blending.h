#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/merging/seam/overlap_side.h"

namespace lsmvs {

// Displacements (#V) that bring the rim of what is kept of a surface towards its matches on the
// other: `share` of the way there, less with the distance from the rim, zero from three edge
// lengths or four times the way that the rim moves on, and where faces outside of the band use the
// vertex. So two surfaces whose shares add up to 1 meet at the seam, and nothing moves far from it.
// `may_move` (#V) receives which vertices lie so near the rim, or within `min_width` of it.
std::vector<Eigen::Vector3d> BlendTowardsMatches(const OverlapSide& side,
                                                 const std::vector<uint8_t>& kept_faces,
                                                 double share, double min_width, double max_width,
                                                 std::vector<uint8_t>* may_move);

}  // namespace lsmvs
