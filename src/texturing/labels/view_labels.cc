#include "lsmvs/texturing/labels/view_labels.h"

#include <algorithm>
#include <cmath>

namespace lsmvs {

namespace {

// V in units of 1 / kOne: kOne is 32 grey levels in three channels, doubled.
constexpr int kOne = 192, kBase = 38;
constexpr int kLengthUnit = LabelEnergy::kUnit / kOne;
constexpr double kMaxCost = 1 << 27;
constexpr double kMaxWeight = kMaxCost / kOne;

}  // namespace

LabelEnergy::LabelEnergy(const TriangleMesh& mesh, const FaceNeighbors& neighbors,
                         const FaceCandidates& candidates, double seam_cost)
    : mesh_(mesh), neighbors_(neighbors), candidates_(candidates), seam_cost_(seam_cost) {}

double LabelEnergy::AreaPx(size_t face) const {
  const double density = candidates_.density(face);
  return 0.5 * FaceNormalTimesTwiceArea(mesh_, face).norm() * density * density;
}

double LabelEnergy::LengthPx(size_t face, int side) const {
  const Eigen::Vector3i& f = mesh_.faces[face];
  const double length = (mesh_.vertices[f[(side + 1) % 3]] - mesh_.vertices[f[side]]).norm();
  const int32_t other = neighbors_[face][static_cast<size_t>(side)];
  const double density =
      other < 0
          ? candidates_.density(face)
          : 0.5 * (candidates_.density(face) + candidates_.density(static_cast<size_t>(other)));
  return length * density;
}

int32_t LabelEnergy::FaceCost(size_t face, size_t slot) const {
  const auto of_face = candidates_.Of(face);
  const double loss = 1 - static_cast<double>(of_face[slot].quality) / of_face[0].quality;
  return static_cast<int32_t>(std::lround(std::min(kMaxCost, kUnit * loss * AreaPx(face))));
}

Eigen::Vector3i LabelEnergy::TwiceColorAt(size_t face, size_t other, int view_idx) const {
  const Candidate* here = candidates_.Find(face, view_idx);
  const Candidate* there = candidates_.Find(other, view_idx);
  if (here == nullptr) here = there;
  if (there == nullptr) there = here;
  return here->color.cast<int>() + there->color.cast<int>();
}

int32_t LabelEnergy::EdgeCost(size_t face, int side, int view_a, int view_b) const {
  if (view_a == view_b) return 0;
  const auto other = static_cast<size_t>(neighbors_[face][static_cast<size_t>(side)]);
  const double weight = std::min(kMaxWeight, kLengthUnit * seam_cost_ * LengthPx(face, side));
  const Eigen::Vector3i difference =
      TwiceColorAt(face, other, view_a) - TwiceColorAt(face, other, view_b);
  return static_cast<int32_t>(std::lround(weight)) *
         std::min(kOne, kBase + difference.cwiseAbs().sum());
}

int64_t LabelEnergy::Total(const ViewSlots& slots) const {
  int64_t total = 0;
  for (size_t f = 0; f < slots.size(); ++f) {
    if (slots[f] == kNoSlot) continue;
    total += FaceCost(f, slots[f]);
    for (int side = 0; side < 3; ++side) {
      const int32_t other = neighbors_[f][static_cast<size_t>(side)];
      if (other < static_cast<int32_t>(f) || slots[static_cast<size_t>(other)] == kNoSlot) continue;
      total += EdgeCost(f, side, ViewOf(slots, f), ViewOf(slots, static_cast<size_t>(other)));
    }
  }
  return total;
}

ViewSlots BestSlots(const FaceCandidates& candidates) {
  ViewSlots slots(candidates.num_faces());
  for (size_t f = 0; f < slots.size(); ++f) slots[f] = candidates.Of(f).empty() ? kNoSlot : 0;
  return slots;
}

}  // namespace lsmvs
