#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/merging/overlap/mesh_band.h"

namespace lsmvs {

// Where two surfaces are to meet, and how long edges should be there.
struct SeamPoints {
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> edge_lengths;
};

// Splits the band's faces so that edges are about as long as the seam asks at the seam, and may
// grow by `growth` of the distance from it. The surface does not change, old vertices stay, edges
// to faces outside of the band are not split; where that cannot be, nothing is split and false is
// returned.
bool RefineTowardsSeam(const SeamPoints& seam, double growth, MeshBand* band);

}  // namespace lsmvs
