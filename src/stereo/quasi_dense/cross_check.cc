#include <algorithm>
#include <limits>

#include "lsmvs/stereo/quasi_dense/cross_check.h"

namespace lsmvs::quasi_dense {

namespace {

constexpr size_t kRowsOfBlock = 16;

bool InGrid(const PointGrid& grid, const Eigen::Vector2f& position) {
  return position.x() >= 0 && position.y() >= 0 &&
         position.x() < static_cast<float>(grid.cells.width) * grid.spacing &&
         position.y() < static_cast<float>(grid.cells.height) * grid.spacing;
}

}  // namespace

float MutualError(const InverseDepthTransferf& back, const Eigen::Vector2f& position,
                  const Eigen::Vector2f& position_in_other, const InterestPoint& other) {
  const Eigen::Vector2f offset = position_in_other - other.position;
  const float inverse_depth = other.plane.Moved(offset.x(), offset.y()).q;
  const Eigen::Vector3f seen = back(position_in_other, inverse_depth);
  if (!(inverse_depth > 0 && seen.z() > 1e-6f)) return std::numeric_limits<float>::infinity();
  return (seen.head<2>() / seen.z() - position).norm();
}

CrossCheck CrossCheckPoint(const Pairing& pairing, const PointGrid& other,
                           const Eigen::Vector2f& position, float inverse_depth,
                           float max_mutual_error_px) {
  CrossCheck check;
  const Eigen::Vector3f seen = pairing.there(position, inverse_depth);
  if (!(seen.z() > 1e-6f)) return check;
  const Eigen::Vector2f place = seen.head<2>() / seen.z();
  if (!InGrid(other, place)) return check;
  check.position = place;
  check.status = CrossCheckStatus::kUnknown;
  ForPointsAround(other, place, 1, [&](const InterestPoint& point) {
    if (!point.matched() || check.status == CrossCheckStatus::kConfirmed) return;
    const bool confirmed = MutualError(pairing.back, position, place, point) <= max_mutual_error_px;
    check.status = confirmed ? CrossCheckStatus::kConfirmed : CrossCheckStatus::kContradicted;
  });
  return check;
}

Raster<uint32_t> ConfirmedSlots(const NeighborGrids& grids, const std::vector<Pairing>& pairings,
                                float max_mutual_error_px, const RunContext& context) {
  const PointGrid& grid = *grids.own;
  Raster<uint32_t> confirmed(grid.cells.width, grid.cells.height, 0);
  const size_t width = static_cast<size_t>(grid.cells.width);
  ParallelFor(context, static_cast<size_t>(grid.cells.height), kRowsOfBlock, [&](size_t row) {
    for (size_t cell = row * width; cell < (row + 1) * width; ++cell) {
      const InterestPoint& point = grid.cells.pixels[cell];
      if (!point.matched()) continue;
      for (size_t s = 0; s < pairings.size(); ++s) {
        const CrossCheck check = CrossCheckPoint(pairings[s], *grids.others[s], point.position,
                                                 point.plane.q, max_mutual_error_px);
        if (check.status == CrossCheckStatus::kConfirmed) confirmed.pixels[cell] |= 1u << s;
      }
    }
  });
  return confirmed;
}

}  // namespace lsmvs::quasi_dense
