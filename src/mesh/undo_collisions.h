#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Takes a step back where it makes the surface pass through itself: vertices of faces that cross
// after the step and did not before return to their position `before`, then those of faces that
// cross because of that, until none is left (every vertex at its old place at the latest, which is
// no worse than before). Returns the number of vertices that returned.
//
// One grid for all places is made once; it cuts the boxes of steps that are many edges long, for
// which `has_long_steps` has it made anew for each pass.
size_t UndoCollisions(std::span<const Eigen::Vector3i> faces,
                      const std::vector<Eigen::Vector3d>& before,
                      std::vector<Eigen::Vector3d>* after, const RunContext& context,
                      bool has_long_steps = false);

}  // namespace lsmvs
