#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/tetrahedralization.h"
#include "lsmvs/surface/visibility_weights.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Capacity that stands for the weight 1: one fully trusted ray.
inline constexpr double kCapacityPerWeight = 512;

inline int32_t ToCapacity(double weight) {
  const double capacity = weight * kCapacityPerWeight + 0.5;
  return static_cast<int32_t>(std::min<double>(capacity, CutNode::kMaxCapacity));
}

struct RayWeights {
  std::vector<Eigen::Vector3d> centers;  // of the views, canonical
  std::vector<float> sigmas;             // #V, canonical
  double sink_distance_factor = 0;
  double sink_weight = 1;
};

// Adds the weights of all rays to the complex' cells: to `capacity` what facets get, to `distance`
// what is tied to the source, to `excess` what is tied to the sink; the sums saturate at about
// CutNode::kMaxCapacity. See WeighCells for what is added.
//
// Two things make it and the cut after it fast. Rays go exactly their way as long as their weight
// depends on the distance; then those of one view join (internal::JoinedPaths). And each ray's
// flow from its view up to its vertex is sent in advance: a facet's weight stands in the direction
// from the vertex to the view, as what could be sent back, and a cell on the way is tied to the
// source with what ends there, the difference of the weights of the facets where the ray leaves
// and enters it. The value of every cut stays the same, and flow has short ways to go.
RayCounters WeighRays(const MergedCloud& cloud, const RayWeights& weights,
                      const RunContext& context, Tetrahedralization* complex);

}  // namespace lsmvs
