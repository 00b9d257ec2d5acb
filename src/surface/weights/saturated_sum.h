#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "lsmvs/graph/minimum_cut.h"

namespace lsmvs::internal {

inline int32_t AddCapacities(int32_t a, int32_t b) {
  return std::min(CutNode::kMaxCapacity, a + b);
}

// Adds to a sum that saturates: as all addends are positive, the result does not depend on their
// order. Threads (kShared) may overshoot, by less than one capacity: who reads the sums cuts off
// what is above the limit.
template <bool kShared>
void AddSaturated(int32_t* sum, int32_t amount) {
  if constexpr (!kShared) {
    *sum = AddCapacities(*sum, amount);
  } else {
    // So small that 4096 threads that add it at once to a sum below the limit do not overflow.
    constexpr int32_t kSmall = CutNode::kMaxCapacity / 4096;
    std::atomic_ref<int32_t> shared(*sum);
    int32_t before = shared.load(std::memory_order_relaxed);
    if (before >= CutNode::kMaxCapacity) return;
    if (amount <= kSmall) {
      shared.fetch_add(amount, std::memory_order_relaxed);
      return;
    }
    while (before < CutNode::kMaxCapacity &&
           !shared.compare_exchange_weak(before, AddCapacities(before, amount),
                                         std::memory_order_relaxed)) {
    }
  }
}

}  // namespace lsmvs::internal
