#include "lsmvs/merging/common_origin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lsmvs/mesh/edge_lengths.h"

namespace lsmvs {

namespace {

// Coordinates are shifted where single precision would lose this part of an edge.
constexpr double kMaxRoundingPart = 0.01, kFloatRounding = 6e-8;

}  // namespace

Eigen::Vector3d ShiftToCommonOrigin(std::vector<MergingInput>* inputs) {
  Eigen::AlignedBox3d box;
  double edge = std::numeric_limits<double>::infinity();
  for (const MergingInput& input : *inputs) {
    for (const Eigen::Vector3d& x : input.mesh.vertices) box.extend(x);
    const double own = MeanEdgeLength(input.mesh);
    if (own > 0) edge = std::min(edge, own);
  }
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  if (box.isEmpty()) return offset;
  const double largest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  if (!(largest * kFloatRounding > kMaxRoundingPart * edge)) return offset;
  const double step = std::exp2(std::ceil(std::log2(std::max(box.diagonal().norm(), 1e-300))));
  offset = (box.center() / step).array().round() * step;
  for (MergingInput& input : *inputs) {
    for (Eigen::Vector3d& x : input.mesh.vertices) x -= offset;
  }
  return offset;
}

}  // namespace lsmvs
