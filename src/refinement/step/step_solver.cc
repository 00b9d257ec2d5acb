#include "lsmvs/refinement/step/step_solver.h"

#include <cmath>

namespace lsmvs {

namespace {

constexpr size_t kBlock = 8192;

double Dot(const std::vector<double>& a, const std::vector<double>& b, const RunContext& context) {
  std::vector<double> sums((a.size() + kBlock - 1) / kBlock, 0.0);
  ParallelBlocks(context, a.size(), kBlock, [&](size_t begin, size_t end) {
    double sum = 0;
    for (size_t i = begin; i < end; ++i) sum += a[i] * b[i];
    sums[begin / kBlock] = sum;
  });
  double total = 0;
  for (const double sum : sums) total += sum;
  return total;
}

}  // namespace

StepSolution SolveStep(const Smoothness& smoothness, const std::vector<double>& diagonal,
                       const std::vector<double>& gradient, const std::vector<uint8_t>& fixed,
                       int max_iterations, double tolerance, const RunContext& context) {
  const size_t count = gradient.size();
  StepSolution solution;
  solution.x.assign(count, 0.0);
  std::vector<double> inverse = smoothness.HessianDiagonal();
  std::vector<double> residual(count), search(count), product, scratch, scaled(count);
  for (size_t v = 0; v < count; ++v) {
    const double total = inverse[v] + diagonal[v];
    inverse[v] = fixed[v] || total <= 0 ? 0.0 : 1.0 / total;
    residual[v] = inverse[v] > 0 ? -gradient[v] : 0.0;
    search[v] = scaled[v] = inverse[v] * residual[v];
  }
  double norm = Dot(residual, scaled, context);
  const double goal = norm * tolerance * tolerance;
  while (solution.num_iterations < max_iterations && norm > goal && norm > 0) {
    context.ThrowIfCancelled();
    smoothness.ApplyHessian(search, context, &scratch, &product);
    ParallelFor(context, count, kBlock, [&](size_t v) {
      product[v] = inverse[v] > 0 ? product[v] + diagonal[v] * search[v] : 0.0;
    });
    const double curvature = Dot(search, product, context);
    if (!(curvature > 0)) break;
    const double step = norm / curvature;
    ParallelFor(context, count, kBlock, [&](size_t v) {
      solution.x[v] += step * search[v];
      residual[v] -= step * product[v];
      scaled[v] = inverse[v] * residual[v];
    });
    const double next_norm = Dot(residual, scaled, context);
    const double ratio = next_norm / norm;
    ParallelFor(context, count, kBlock,
                [&](size_t v) { search[v] = scaled[v] + ratio * search[v]; });
    norm = next_norm;
    ++solution.num_iterations;
  }
  return solution;
}

}  // namespace lsmvs
