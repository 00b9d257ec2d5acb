#include "lsmvs/texturing/exposure/exposure_gains.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "lsmvs/image/sampling.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

constexpr std::array<double, 5> kGains = {0.8, 1.25, 1.0, 0.9, 1.1};

// Photos of random faces, three of each, a tenth of them of something else.
FaceCandidates Photos(const std::array<double, 5>& gains) {
  Random random(2);
  FaceCandidates candidates(20000, 3);
  for (size_t f = 0; f < candidates.num_faces(); ++f) {
    const Eigen::Vector3f color(static_cast<float>(random.Uniform(40, 160)),
                                static_cast<float>(random.Uniform(40, 160)),
                                static_cast<float>(random.Uniform(40, 160)));
    const auto first = static_cast<int>(random.Below(5));
    for (int k = 0; k < 3; ++k) {
      Candidate candidate;
      candidate.view_idx = (first + k) % 5;
      candidate.quality = static_cast<float>(random.Uniform(1, 2));
      const auto gain = static_cast<float>(gains[static_cast<size_t>(candidate.view_idx)]);
      const auto noise = static_cast<float>(random.Gaussian());
      candidate.color = RoundColor(((gain * color).array() + noise).matrix());
      if (random.Uniform() < 0.1) candidate.color = Color(200, 30, 30);
      candidates.Add(f, candidate, 1.0f);
    }
  }
  candidates.Compact();
  return candidates;
}

TEST(ExposureGains, AreFoundWithinAPercent) {
  FaceCandidates candidates = Photos(kGains);
  const ExposureGains gains = EstimateExposureGains(candidates, 5);
  EXPECT_TRUE(gains.is_used);
  EXPECT_LT(gains.error_after, 0.6 * gains.error_before);
  double mean_log = 0;
  for (const double gain : kGains) mean_log += std::log(gain) / 5;
  for (size_t v = 0; v < 5; ++v) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(gains.factors[v][c] * kGains[v] / std::exp(mean_log), 1.0, 0.01);
    }
  }
  ApplyExposureGains(gains, &candidates);
  EXPECT_FALSE(EstimateExposureGains(candidates, 5).is_used);
}

TEST(ExposureGains, AreOneWhereNothingIsToBeGained) {
  const ExposureGains gains = EstimateExposureGains(Photos({1, 1, 1, 1, 1}), 5);
  EXPECT_FALSE(gains.is_used);
  for (const Eigen::Vector3f& factor : gains.factors) EXPECT_EQ(factor, Eigen::Vector3f::Ones());
  EXPECT_EQ(EstimateExposureGains(FaceCandidates(0, 1), 2).factors.size(), 2u);
}

}  // namespace
}  // namespace lsmvs
