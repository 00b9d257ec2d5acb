#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/regions/face_regions.h"

namespace lsmvs {

// Parts of the surface that move one after the other: clusters of regions, coloured so that
// clusters of a colour share no vertex.
struct ClusterColors {
  int num_colors = 1;
  std::vector<uint8_t> of_region;  // colours of the regions
};

// Clusters have about `faces_per_cluster` faces and consist of whole regions. Colours are given
// greedily. O(#F).
ClusterColors ColorClusters(const TriangleMesh& mesh, const FaceRegions& regions,
                            int faces_per_cluster);

}  // namespace lsmvs
