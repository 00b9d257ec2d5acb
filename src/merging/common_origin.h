#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/merging/mesh_merger.h"

namespace lsmvs {

// Subtracts a common origin from the inputs where coordinates are so large, such as UTM's, that
// single precision would lose a hundredth of an edge, and returns it; else zero. It is a multiple
// of a power of two, so that no digit is lost, and does not depend on the order of the inputs.
Eigen::Vector3d ShiftToCommonOrigin(std::vector<MergingInput>* inputs);

}  // namespace lsmvs
