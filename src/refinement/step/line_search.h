#pragma once

#include <functional>
#include <vector>

namespace lsmvs {

// Value of a function at x; writes its gradient if asked for.
using DifferentiableFunction =
    std::function<double(const std::vector<double>& x, std::vector<double>* gradient)>;

struct LineSearchOptions {
  int max_num_iterations = 8;
  // Ends when a step lowers the function by less than this part of it.
  double min_relative_gain = 0.002;
};

// Minimises a function from x = 0 (`count` variables) by L-BFGS with a line search (Ceres). Writes
// the value before the first and after every step. What `function` throws comes out.
std::vector<double> MinimizeByLbfgs(size_t count, const DifferentiableFunction& function,
                                    const LineSearchOptions& options, std::vector<double>* values);

}  // namespace lsmvs
