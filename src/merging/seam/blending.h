#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/merging/seam/seam_labels.h"

namespace lsmvs {

// Displacements (#V) that bring the rim of what is kept of a surface towards its matches on the
// other: `share` of the way there, less with the distance from the rim, zero from some edge lengths
// or six offsets on, and where faces outside of the band use the vertex. So two surfaces whose
// shares add up to 1 meet at the seam, and nothing moves far from it. `from_rim` (#V) receives the
// distances along the surface, infinite beyond the moved part.
std::vector<Eigen::Vector3d> BlendTowardsMatches(const OverlapSide& side,
                                                 const std::vector<uint8_t>& kept_faces,
                                                 double share, double max_width,
                                                 std::vector<double>* from_rim);

}  // namespace lsmvs
