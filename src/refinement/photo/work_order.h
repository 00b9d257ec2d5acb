#pragma once

#include <cstddef>
#include <vector>

#include "lsmvs/refinement/photo/pair_selection.h"

namespace lsmvs {

// The first views of pairs (sorted by i), each once, in the order in which they are best worked on:
// next comes a view for which the fewest maps have to be drawn that none before needed, so that few
// are needed at a time. O((#pairs + #views) #views).
std::vector<int> WorkOrder(const std::vector<ViewPair>& pairs, size_t num_views);

}  // namespace lsmvs
