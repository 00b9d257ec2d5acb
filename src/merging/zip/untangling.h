#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Moves vertices with `may_move` (#V) towards the mean of their neighbours where faces with
// `is_active` (#F) cross others or lie folded on their neighbours, until none do or it does not
// help. Moved vertices are set in `has_moved` (#V), their faces become active. Returns the number of
// crossing pairs that are left. O(#F) for each of at most some ten steps.
size_t UntangleFaces(const std::vector<uint8_t>& may_move, const RunContext& context,
                     std::vector<uint8_t>* is_active, std::vector<uint8_t>* has_moved,
                     TriangleMesh* mesh);

}  // namespace lsmvs
