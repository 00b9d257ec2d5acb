#pragma once

#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/refinement/photo/photo_energy.h"

namespace lsmvs {

// How much the photos confirm each vertex (#V, 0 to 1): the product of
// - how alike the photos are there, over the faces at the vertex: 1 for the same, 0 for photos that
//   have nothing in common; 1/2 where there is no texture that could tell, and in between where
//   there is little;
// - how many photos that is: 1 - exp(-n^2 / (2 * 1.5^2)) for n photos that judge the faces at the
//   vertex: 0.59 for two, 0.86 for three, 0.97 for four.
// 0 where no pair of photos sees a face at the vertex. `pairs` and `terms` are those of `mesh`.
std::vector<float> VertexQuality(const TriangleMesh& mesh, const FacePairs& pairs,
                                 const PhotoTerms& terms);

}  // namespace lsmvs
