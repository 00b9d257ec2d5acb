#include "lsmvs/refinement/step/line_search.h"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <exception>

namespace lsmvs {

namespace {

class Function : public ceres::FirstOrderFunction {
 public:
  Function(size_t count, const DifferentiableFunction& function, std::exception_ptr* thrown)
      : count_(count), function_(function), thrown_(*thrown) {}

  // Ceres is not made to be thrown through: a failed evaluation ends it.
  bool Evaluate(const double* x, double* value, double* gradient) const override {
    try {
      const std::vector<double> at(x, x + count_);
      std::vector<double> slopes;
      *value = function_(at, gradient != nullptr ? &slopes : nullptr);
      if (gradient != nullptr) std::copy(slopes.begin(), slopes.end(), gradient);
      return true;
    } catch (...) {
      thrown_ = std::current_exception();
      return false;
    }
  }
  int NumParameters() const override { return static_cast<int>(count_); }

 private:
  size_t count_;
  const DifferentiableFunction& function_;
  std::exception_ptr& thrown_;
};

// Notes the value after every step.
class ValueRecorder : public ceres::IterationCallback {
 public:
  explicit ValueRecorder(std::vector<double>* values) : values_(*values) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    values_.push_back(summary.cost);
    return ceres::SOLVER_CONTINUE;
  }

 private:
  std::vector<double>& values_;
};

}  // namespace

std::vector<double> MinimizeByLbfgs(size_t count, const DifferentiableFunction& function,
                                    const LineSearchOptions& options, std::vector<double>* values) {
  std::vector<double> x(count, 0.0);
  std::exception_ptr thrown;
  const ceres::GradientProblem problem(new Function(count, function, &thrown));
  ceres::GradientProblemSolver::Options solving;
  solving.line_search_direction_type = ceres::LBFGS;
  solving.max_num_iterations = options.max_num_iterations;
  solving.function_tolerance = options.min_relative_gain;
  solving.logging_type = ceres::SILENT;
  ValueRecorder recorder(values);
  solving.callbacks.push_back(&recorder);
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solving, problem, x.data(), &summary);
  if (thrown) std::rethrow_exception(thrown);
  return x;
}

}  // namespace lsmvs
