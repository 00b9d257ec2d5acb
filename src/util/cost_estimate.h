#pragma once

#include <cstddef>

namespace lsmvs {

// What a stage expects to need, for the plan that is printed before a run. Every stage's header has
// an Estimate function that says what it is computed from; the figures are checked against measured
// runs.
struct CostEstimate {
  double cpu_seconds =
      0;  // on one core of a 2020s x86-64 with AVX2; wall time is about this over the threads
  size_t peak_bytes = 0;  // beyond the program itself
};

}  // namespace lsmvs
