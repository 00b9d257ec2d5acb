#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "lsmvs/stereo/quasi_dense/pairs.h"
#include "lsmvs/stereo/quasi_dense/points.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs::quasi_dense {

// What the matches of another view say about a point of this one.
enum class CrossCheckStatus {
  kUnseen,        // the point lies outside of the other image or behind its camera
  kUnknown,       // no matched interest point where the point lies
  kContradicted,  // the points there lie at another depth
  kConfirmed,     // one of them is matched back to within the tolerance
};

struct CrossCheck {
  CrossCheckStatus status = CrossCheckStatus::kUnseen;
  Eigen::Vector2f position = {-1, -1};  // image coordinates of the point in the other view
};

// Asks the interest points around the point's image in the other view. The plane of each says where
// the point would be seen in this view if it lay on it; the nearest such place to `position`
// counts.
CrossCheck CrossCheckPoint(const Pairing& pairing, const PointGrid& other,
                           const Eigen::Vector2f& position, float inverse_depth,
                           float max_mutual_error_px);

// Same for one interest point of the other view: the distance in this view, pixels; infinite behind
// the camera.
float MutualError(const InverseDepthTransferf& back, const Eigen::Vector2f& position,
                  const Eigen::Vector2f& position_in_other, const InterestPoint& other);

// Grids of a view and of its neighbours: others[s] is that of the view of its pairing s.
struct NeighborGrids {
  std::shared_ptr<const PointGrid> own;
  std::vector<std::shared_ptr<const PointGrid>> others;
};

// Neighbours (bits of InterestPoint::slots) that confirm each matched point of a view, by cell.
Raster<uint32_t> ConfirmedSlots(const NeighborGrids& grids, const std::vector<Pairing>& pairings,
                                float max_mutual_error_px, const RunContext& context);

}  // namespace lsmvs::quasi_dense
