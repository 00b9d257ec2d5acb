#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/mesh/vertex_rings.h"
#include "lsmvs/refinement/regions/face_regions.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// How much stiffer than at creases the thin plate is at each vertex.
//
// Real surfaces are smooth nearly everywhere and have creases in few places; noise is the same
// everywhere. So the plate is `flat_stiffness` times as stiff where the surface bends no more than
// is usual around, and of its own stiffness where it bends much more:
//   factor = 1 + (flat_stiffness - 1) / (1 + (c / (0.7 m))^2),
// c the mean squared Laplacian over a vertex and its ring, m the median of c over the region and
// those that it touches, at most 0.02 / px^2: surfaces
// that bend with a radius of a few pixels everywhere are not noise. Iterated with the steps of the
// optimiser, this is a redescending prior on curvature, solved by reweighting. Lengths are in
// pixels.
class CreaseWeights {
 public:
  // `regions` pool the medians; both belong to `mesh`, which is not kept.
  CreaseWeights(const TriangleMesh& mesh, const FaceRegions& regions, double flat_stiffness);

  // From #V squared Laplacians (Smoothness::SquaredLaplacians): #V factors from 1 to
  // `flat_stiffness`; 1 at vertices without faces. O(#V).
  std::vector<float> Factors(const std::vector<double>& squared_laplacians,
                             const VertexRings& rings, const RunContext& context) const;

 private:
  double flat_stiffness_;
  std::vector<int32_t> region_of_vertex_;           // that of its first face; -1: none
  std::vector<std::vector<int32_t>> neighborhood_;  // of each region: itself and those it touches
};

}  // namespace lsmvs
