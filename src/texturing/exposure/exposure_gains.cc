#include "lsmvs/texturing/exposure/exposure_gains.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "lsmvs/image/sampling.h"

namespace lsmvs {

namespace {

constexpr size_t kMaxFaces = 40000;
constexpr size_t kHeldBackOneOf = 5;
constexpr int kDarkest = 12, kBrightest = 243;  // beyond, a photo may be clipped
constexpr double kHuber = 0.05;                 // difference of logarithms: 5 %
constexpr int kIterations = 8;
constexpr double kRegularisation = 1e-3;  // of the mean weight of a view
constexpr double kMinImprovement = 0.05;

// Two photos of a face.
struct PairSample {
  uint32_t pair;
  Eigen::Vector3f difference;  // log first - log second
};

struct Samples {
  std::vector<std::pair<int, int>> views;  // of each pair
  std::vector<PairSample> used, held_back;
};

bool IsExposed(const Color& color) {
  return color.minCoeff() >= kDarkest && color.maxCoeff() <= kBrightest;
}

Eigen::Vector3f LogColor(const Color& color) { return color.cast<float>().array().log().matrix(); }

// Each candidate with the best one and with the one after it.
Samples CollectSamples(const FaceCandidates& candidates) {
  Samples samples;
  std::map<std::pair<int, int>, uint32_t> pairs;
  const size_t stride = std::max<size_t>(1, candidates.num_faces() / kMaxFaces);
  const auto add = [&](const Candidate& a, const Candidate& b, bool is_held_back) {
    if (!IsExposed(a.color) || !IsExposed(b.color)) return;
    const Candidate& low = a.view_idx < b.view_idx ? a : b;
    const Candidate& high = a.view_idx < b.view_idx ? b : a;
    const std::pair<int, int> key(low.view_idx, high.view_idx);
    const auto [found, is_new] = pairs.emplace(key, static_cast<uint32_t>(pairs.size()));
    if (is_new) samples.views.push_back(key);
    auto& list = is_held_back ? samples.held_back : samples.used;
    list.push_back({found->second, LogColor(low.color) - LogColor(high.color)});
  };
  for (size_t f = 0, count = 0; f < candidates.num_faces(); f += stride) {
    const auto of_face = candidates.Of(f);
    if (of_face.size() < 2) continue;
    const bool is_held_back = ++count % kHeldBackOneOf == 0;
    for (size_t k = 1; k < of_face.size(); ++k) {
      add(of_face[0], of_face[k], is_held_back);
      if (k > 1) add(of_face[k - 1], of_face[k], is_held_back);
    }
  }
  return samples;
}

double Residual(const Samples& samples, const PairSample& sample, const Eigen::VectorXd& log_gain,
                int channel) {
  const auto& [i, j] = samples.views[sample.pair];
  return sample.difference[channel] - (log_gain[i] - log_gain[j]);
}

// One step of reweighted least squares.
void Improve(const Samples& samples, int channel, Eigen::VectorXd* log_gain) {
  std::vector<double> weights(samples.views.size(), 0.0), sums(samples.views.size(), 0.0);
  for (const PairSample& sample : samples.used) {
    const double residual = std::abs(Residual(samples, sample, *log_gain, channel));
    const double weight = residual <= kHuber ? 1.0 : kHuber / residual;
    weights[sample.pair] += weight;
    sums[sample.pair] += weight * sample.difference[channel];
  }
  const auto n = log_gain->size();
  double total = 0;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (size_t p = 0; p < samples.views.size(); ++p) {
    const auto& [i, j] = samples.views[p];
    entries.emplace_back(i, i, weights[p]);
    entries.emplace_back(j, j, weights[p]);
    entries.emplace_back(i, j, -weights[p]);
    entries.emplace_back(j, i, -weights[p]);
    right[i] += sums[p];
    right[j] -= sums[p];
    total += weights[p];
  }
  const double regularisation = 1e-12 + kRegularisation * 2 * total / static_cast<double>(n);
  for (int v = 0; v < n; ++v) entries.emplace_back(v, v, regularisation);
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  *log_gain = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
}

// Mean Huber loss, in units of the difference.
double HeldBackError(const Samples& samples, const std::vector<Eigen::VectorXd>& log_gains) {
  double sum = 0;
  for (const PairSample& sample : samples.held_back) {
    for (int c = 0; c < 3; ++c) {
      const double r = std::abs(Residual(samples, sample, log_gains[static_cast<size_t>(c)], c));
      sum += r <= kHuber ? 0.5 * r * r / kHuber : r - 0.5 * kHuber;
    }
  }
  return samples.held_back.empty() ? 0
                                   : sum / (3.0 * static_cast<double>(samples.held_back.size()));
}

}  // namespace

ExposureGains EstimateExposureGains(const FaceCandidates& candidates, size_t num_views) {
  const Samples samples = CollectSamples(candidates);
  const auto n = static_cast<Eigen::Index>(num_views);
  std::vector<Eigen::VectorXd> log_gains(3, Eigen::VectorXd::Zero(n));
  ExposureGains gains;
  gains.error_before = HeldBackError(samples, log_gains);
  for (int c = 0; c < 3 && !samples.used.empty(); ++c) {
    for (int i = 0; i < kIterations; ++i) Improve(samples, c, &log_gains[static_cast<size_t>(c)]);
  }
  gains.error_after = HeldBackError(samples, log_gains);
  gains.is_used = gains.error_after < (1 - kMinImprovement) * gains.error_before;
  gains.factors.assign(num_views, Eigen::Vector3f::Ones());
  for (size_t v = 0; v < num_views && gains.is_used; ++v) {
    for (int c = 0; c < 3; ++c) {
      gains.factors[v][c] = static_cast<float>(
          std::exp(-log_gains[static_cast<size_t>(c)][static_cast<Eigen::Index>(v)]));
    }
  }
  return gains;
}

void ApplyExposureGains(const ExposureGains& gains, FaceCandidates* candidates) {
  if (!gains.is_used) return;
  for (size_t f = 0; f < candidates->num_faces(); ++f) {
    for (Candidate& c : candidates->Of(f)) {
      const Eigen::Vector3f& factor = gains.factors[static_cast<size_t>(c.view_idx)];
      c.color = RoundColor(c.color.cast<float>().cwiseProduct(factor));
    }
  }
}

}  // namespace lsmvs
