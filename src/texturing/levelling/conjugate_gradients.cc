#include "lsmvs/texturing/levelling/conjugate_gradients.h"

namespace lsmvs {

namespace {

using Dots = Eigen::Array3d;

Dots Dot(const Channels& a, const Channels& b) {
  Dots sums = Dots::Zero();
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (int c = 0; c < 3; ++c) sums[c] += static_cast<double>(a(i, c)) * b(i, c);
  }
  return sums;
}

// a / b, and 0 where there is nothing left to do.
Eigen::Array3f Ratio(const Dots& a, const Dots& b) {
  return (b > 0).select(a / b.max(1e-300), 0.0).cast<float>();
}

void AddScaled(const Eigen::Array3f& factors, const Channels& a, Channels* sum) {
  for (int c = 0; c < 3; ++c) sum->col(c) += factors[c] * a.col(c);
}

}  // namespace

int SolveConjugateGradients(const std::function<void(const Channels& x, Channels* y)>& apply,
                            const Eigen::VectorXf& diagonal, const Channels& b,
                            const ConjugateGradientOptions& options, Channels* x) {
  Channels product(b.rows(), 3);
  apply(*x, &product);
  Channels residual = b - product;
  const auto precondition = [&](Channels* z) {
    *z = residual.array().colwise() / diagonal.array();
  };
  Channels direction(b.rows(), 3), z(b.rows(), 3);
  precondition(&direction);
  Dots descent = Dot(residual, direction);
  const Dots enough = options.tolerance * options.tolerance * Dot(b, b);
  for (int i = 0; i < options.max_num_iterations; ++i) {
    if ((Dot(residual, residual) <= enough).all()) return i;
    apply(direction, &product);
    const Eigen::Array3f step = Ratio(descent, Dot(direction, product));
    AddScaled(step, direction, x);
    AddScaled(-step, product, &residual);
    precondition(&z);
    const Dots next = Dot(residual, z);
    const Eigen::Array3f turn = Ratio(next, descent);
    for (int c = 0; c < 3; ++c) direction.col(c) = z.col(c) + turn[c] * direction.col(c);
    descent = next;
  }
  return options.max_num_iterations;
}

}  // namespace lsmvs
