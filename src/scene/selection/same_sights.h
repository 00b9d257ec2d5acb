#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "lsmvs/scene/scene.h"

namespace lsmvs {

// Tells photos that show the same from the same place: a photo that is twice in the model, bursts,
// frames of a video that hardly moves. As neighbours of a third photo they count as one, since
// their errors are the same and they confirm each other without new evidence.
class SameSights {
 public:
  // Views that see a place under less than `min_angle_deg` between each other see it from the same
  // side.
  SameSights(const Scene& scene, double min_angle_deg);

  // Whether two views show the same of `places`, which are points of the surface that a third photo
  // shows: at least three quarters of those in the first one's image lie in the second one's, too,
  // are seen at like scale there (focal lengths within 1.5) and under less than the minimum angle,
  // in the median. Where no place is known: whether the views stand in one place (CenterGroups)
  // and their axes agree within 15 degrees. O(places).
  bool ShowTheSame(std::span<const Eigen::Vector3d> places, int view_idx, int other_idx) const;
  // Whether they stand in one place, as CenterGroups has it: without any baseline.
  bool StandInOnePlace(int view_idx, int other_idx) const {
    return groups_[static_cast<size_t>(view_idx)] == groups_[static_cast<size_t>(other_idx)];
  }

 private:
  bool LookTheSameWay(const View& view, const View& other) const;

  const Scene& scene_;
  const double min_angle_deg_;
  std::vector<Eigen::Vector3d> centers_;
  std::vector<int> groups_;
};

}  // namespace lsmvs
