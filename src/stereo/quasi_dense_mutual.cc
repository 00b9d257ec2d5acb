#include <algorithm>
#include <limits>

#include "lsmvs/stereo/quasi_dense_mutual_internal.h"

namespace lsmvs::quasi_dense {

namespace {

constexpr size_t kRowsOfBlock = 16;

bool InGrid(const PointGrid& grid, const Eigen::Vector2f& position) {
  return position.x() >= 0 && position.y() >= 0 &&
         position.x() < static_cast<float>(grid.cells.width) * grid.spacing &&
         position.y() < static_cast<float>(grid.cells.height) * grid.spacing;
}

}  // namespace

float MutualError(const PairGeometry& back, const Eigen::Vector2f& position,
                  const Eigen::Vector2f& position_in_other, const InterestPoint& other) {
  const Eigen::Vector2f offset = position_in_other - other.position;
  const float inverse_depth = other.plane.Moved(offset.x(), offset.y()).q;
  const Eigen::Vector3f seen = back.Transfer(position_in_other, inverse_depth);
  if (!(inverse_depth > 0 && seen.z() > 1e-6f)) return std::numeric_limits<float>::infinity();
  return (seen.head<2>() / seen.z() - position).norm();
}

Witness AskWitness(const Pairing& pairing, const PointGrid& other, const Eigen::Vector2f& position,
                   float inverse_depth, float max_mutual_error_px) {
  Witness witness;
  const Eigen::Vector3f seen = pairing.there.Transfer(position, inverse_depth);
  if (!(seen.z() > 1e-6f)) return witness;
  const Eigen::Vector2f place = seen.head<2>() / seen.z();
  if (!InGrid(other, place)) return witness;
  witness.position = place;
  witness.testimony = Testimony::kUnknown;
  ForPointsAround(other, place, 1, [&](const InterestPoint& point) {
    if (!point.matched() || witness.testimony == Testimony::kConfirmed) return;
    const bool confirmed = MutualError(pairing.back, position, place, point) <= max_mutual_error_px;
    witness.testimony = confirmed ? Testimony::kConfirmed : Testimony::kContradicted;
  });
  return witness;
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
        const Witness witness = AskWitness(pairings[s], *grids.others[s], point.position,
                                           point.plane.q, max_mutual_error_px);
        if (witness.testimony == Testimony::kConfirmed) confirmed.pixels[cell] |= 1u << s;
      }
    }
  });
  return confirmed;
}

}  // namespace lsmvs::quasi_dense
