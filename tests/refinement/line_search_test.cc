#include "lsmvs/refinement/step/line_search.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace lsmvs {
namespace {

TEST(MinimizeByLbfgs, FindsTheMinimumOfAQuadratic) {
  const std::vector<double> target = {1, -2, 3, 0.5}, weights = {1, 10, 0.1, 4};
  std::vector<double> values;
  const auto x = MinimizeByLbfgs(
      4,
      [&](const std::vector<double>& at, std::vector<double>* gradient) {
        double value = 0;
        if (gradient != nullptr) gradient->assign(4, 0.0);
        for (size_t k = 0; k < 4; ++k) {
          value += weights[k] * (at[k] - target[k]) * (at[k] - target[k]);
          if (gradient != nullptr) (*gradient)[k] = 2 * weights[k] * (at[k] - target[k]);
        }
        return value;
      },
      {60, 1e-12}, &values);
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(x[k], target[k], 1e-4);
  ASSERT_GT(values.size(), 2u);
  for (size_t k = 1; k < values.size(); ++k) EXPECT_LE(values[k], values[k - 1]);
}

TEST(MinimizeByLbfgs, PassesOnWhatTheFunctionThrows) {
  std::vector<double> values;
  const auto fails = [](const std::vector<double>&, std::vector<double>*) -> double {
    throw std::runtime_error("stopped");
  };
  EXPECT_THROW(MinimizeByLbfgs(2, fails, {}, &values), std::runtime_error);
}

}  // namespace
}  // namespace lsmvs
