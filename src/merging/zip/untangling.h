#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Moves vertices with `may_move` (#V) towards the mean of their neighbours where faces at them, at
// vertices with `has_moved` (#V) or from `first_new` on cross others, or where faces from
// `first_new` on lie folded on their neighbours, until none do or it does not help. Sets
// `has_moved`. Returns a vertex of each crossing pair that is left. O(#F), and some ten times the
// faces around the crossings.
std::vector<int32_t> UntangleFaces(const std::vector<uint8_t>& may_move, size_t first_new,
                                   const RunContext& context, std::vector<uint8_t>* has_moved,
                                   TriangleMesh* mesh);

}  // namespace lsmvs
