#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/texturing/candidates/face_candidates.h"

namespace lsmvs {

struct ExposureGains {
  // Per view the factor of red, green and blue that makes its colours fit those of the others.
  std::vector<Eigen::Vector3f> factors;
  // Mean robust difference of log colours between photos of a face on samples that were held back,
  // with factors of 1 and with those found. Where these are not better by a twentieth, all factors
  // are 1.
  double error_before = 0, error_after = 0;
  bool is_used = false;
};

// Robust least squares (Huber, by reweighting) over pairs of photos of the same face: the
// difference of the logarithms of their colours is that of the views' gains. Weakly regularised
// towards 1; the mean of the logarithms is 0. At most about 40,000 faces, evenly from all.
ExposureGains EstimateExposureGains(const FaceCandidates& candidates, size_t num_views);

// Multiplies the colours of all candidates.
void ApplyExposureGains(const ExposureGains& gains, FaceCandidates* candidates);

}  // namespace lsmvs
