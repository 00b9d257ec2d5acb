#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/merging/seam/overlap_side.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct SeamOptions {
  // Edge lengths that the seam keeps from where a surface ends, if the overlap is wide enough.
  double inset = 3;
};

// Which faces of the first surface (#F) stay: 1, or make way for the second: 0. A minimum cut.
// Each surface stays where it is alone; where both are, the finer one is preferred, and the seam
// runs where it is short and the surfaces are close. Ties favour the second.
std::vector<uint8_t> LabelFirstSurface(const OverlapSide& first, const OverlapSide& second,
                                       const SeamOptions& options, const RunContext& context);

// Which faces of the second surface stay, given the labels of the first: those that are not over a
// face that stays and keep `clearance` edge lengths from the seam.
std::vector<uint8_t> LabelSecondSurface(const OverlapSide& first, const OverlapSide& second,
                                        const std::vector<uint8_t>& first_labels, double clearance,
                                        const RunContext& context);

}  // namespace lsmvs
