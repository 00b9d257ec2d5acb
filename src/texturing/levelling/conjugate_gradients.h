#pragma once

#include <Eigen/Core>
#include <functional>

namespace lsmvs {

// A number per unknown for each of three channels.
using Channels = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

struct ConjugateGradientOptions {
  double tolerance = 1e-4;  // residual relative to the right side, per channel
  int max_num_iterations = 500;
};

// Solves A x = b for three right sides with one symmetric positive definite A, by conjugate
// gradients with the diagonal as preconditioner. `apply(x, y)` sets y = A x; `diagonal`: that of A,
// all > 0. `x` holds the start and receives the result. Returns the number of iterations. Sums in
// double and in fixed order. Memory: 4 times that of x.
int SolveConjugateGradients(const std::function<void(const Channels& x, Channels* y)>& apply,
                            const Eigen::VectorXf& diagonal, const Channels& b,
                            const ConjugateGradientOptions& options, Channels* x);

}  // namespace lsmvs
