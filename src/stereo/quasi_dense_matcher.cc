#include "lsmvs/stereo/quasi_dense_matcher.h"

namespace lsmvs {

QuasiDenseResult MatchQuasiDense(const Scene&, const ImageStore&,
                                 const std::vector<std::vector<Neighbor>>&,
                                 std::span<const std::vector<Eigen::Vector2f>>,
                                 const QuasiDenseOptions&, const RunContext&) {
  QuasiDenseResult result;
  result.status = QuasiDenseStatus::kNoMatches;
  return result;
}

CostEstimate EstimateQuasiDenseCost(const Scene&, const ImageStore&, const QuasiDenseOptions&) {
  return {};
}

}  // namespace lsmvs
