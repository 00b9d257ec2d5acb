#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "lsmvs/surface/minimum_cut.h"

namespace lsmvs::internal {

inline int32_t AddCapacities(int32_t a, int32_t b) {
  return std::min(CutNode::kMaxCapacity, a + b);
}

// Adds to a sum that saturates: as all addends are positive, the result does not depend on their
// order. Threads (kShared) may overshoot: who reads the sums cuts off what is above the limit.
template <bool kShared>
void AddSaturated(int32_t* sum, int32_t amount) {
  if constexpr (!kShared) {
    *sum = AddCapacities(*sum, amount);
  } else {
    std::atomic_ref<int32_t> shared(*sum);
    if (shared.load(std::memory_order_relaxed) < CutNode::kMaxCapacity) {
      shared.fetch_add(amount, std::memory_order_relaxed);
    }
  }
}

}  // namespace lsmvs::internal
