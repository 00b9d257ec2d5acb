#include "lsmvs/texturing/levelling/conjugate_gradients.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

TEST(ConjugateGradients, AgreeWithLdlt) {
  constexpr int kSize = 40;
  Random random(5);
  Eigen::MatrixXf factor(kSize, kSize);
  for (int i = 0; i < factor.size(); ++i) {
    factor.data()[i] = static_cast<float>(random.Gaussian());
  }
  const Eigen::MatrixXf matrix =
      factor * factor.transpose() + 5.0f * Eigen::MatrixXf::Identity(kSize, kSize);
  Channels b(kSize, 3), x = Channels::Zero(kSize, 3);
  for (int i = 0; i < b.size(); ++i) b.data()[i] = static_cast<float>(random.Gaussian());
  const auto apply = [&](const Channels& in, Channels* out) { *out = matrix * in; };
  ConjugateGradientOptions options;
  options.tolerance = 1e-6;
  EXPECT_LT(SolveConjugateGradients(apply, matrix.diagonal(), b, options, &x), 200);
  const Eigen::MatrixXd exact = matrix.cast<double>().ldlt().solve(b.cast<double>());
  EXPECT_LT((x.cast<double>() - exact).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(ConjugateGradients, StopAtOnceWithoutWork) {
  const auto apply = [](const Channels& in, Channels* out) { *out = in; };
  Channels x = Channels::Zero(3, 3);
  EXPECT_EQ(SolveConjugateGradients(apply, Eigen::VectorXf::Ones(3), x, {}, &x), 0);
}

}  // namespace
}  // namespace lsmvs
