#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace lsmvs {

// Positions of some tens of thousands of a cloud's points, spread over the cloud; finite ones only.
std::vector<Eigen::Vector3f> SamplePositions(std::span<const Eigen::Vector3f> positions);

// Share of the points of each cloud that lie where some other cloud has points, too: in the same
// cell of a grid of about 32 cells along the smallest cloud. 0 for an empty cloud.
std::vector<double> OverlapShares(const std::vector<std::vector<Eigen::Vector3f>>& clouds);

// What to tell the user if a cloud lies where no other has points: each cloud's share, middle and
// size, and the likely cause. Else empty. `names` are the clouds'.
std::string NoOverlapWarning(const std::vector<std::string>& names,
                             const std::vector<std::vector<Eigen::Vector3f>>& clouds);

}  // namespace lsmvs
