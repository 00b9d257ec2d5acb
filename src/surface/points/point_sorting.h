#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Puts the points of a cloud in the order of their places: cell by cell of a coarse grid, along a
// Hilbert curve, so that work on a place touches few chunks of a cloud that lies in scratch memory,
// whatever order it was read in. Points of one cell keep their order.
//
// Returns the place of each point (#P) in the new order. O(n): goes through each array twice, with
// a part of it in memory at a time. Beside the cloud 20 bytes a point or, if that is more, 12 bytes
// a point and 4 for each of its views. Throws CancelledError between arrays.
std::vector<uint32_t> SortByPlace(VisibilityCloud* cloud, const RunContext& context);

}  // namespace lsmvs
