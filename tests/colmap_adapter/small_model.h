#pragma once

#include "lsmvs/colmap_adapter/sparse_model.h"

namespace lsmvs {

// A consistent model that has a bit of everything: 2 cameras, 3 images (one without features, one
// in a sub-folder), 2 points and, on request, a rig of two cameras with frames in another order
// than the images.
SparseModel SmallModel(bool with_rigs);

// Fails the test where two models differ; numbers must be equal to the last bit.
void ExpectSameModel(const SparseModel& a, const SparseModel& b);

}  // namespace lsmvs
