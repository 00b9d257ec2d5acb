#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/scene/visibility_cloud.h"

namespace lsmvs {

// The points of a cloud in another order.
struct ShuffledCloud {
  VisibilityCloud cloud;
  std::vector<size_t> origin;  // by point: where it was
};

ShuffledCloud Shuffle(const VisibilityCloud& cloud, uint64_t seed);

}  // namespace lsmvs
