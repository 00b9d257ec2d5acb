#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/refinement/step/smoothness.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct StepSolution {
  std::vector<double> x;
  int num_iterations = 0;
};

// Solves (diag(diagonal) + Hessian of `smoothness`) x = -gradient by conjugate gradients with the
// matrix' diagonal as preconditioner, with x_v = 0 where `fixed[v]`. Ends when the residual has
// fallen to `tolerance` of the first or after `max_iterations`. `diagonal` >= 0. Sums run over
// fixed blocks in a fixed order.
StepSolution SolveStep(const Smoothness& smoothness, const std::vector<double>& diagonal,
                       const std::vector<double>& gradient, const std::vector<uint8_t>& fixed,
                       int max_iterations, double tolerance, const RunContext& context);

}  // namespace lsmvs
