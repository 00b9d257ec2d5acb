#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/refinement/photo/photo_energy.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct FinishingOptions {
  // Faces at the surface's end whose photos disagree go: price of a pixel of border in square
  // pixels of such faces. 0: none go.
  double border_cost = 30.0;
  int min_component_faces = 50;
  // Holes of at most so many edges are closed. 0: none.
  int max_hole_edges = 40;
};

struct FinishingSummary {
  size_t num_dropped_faces = 0;
  size_t num_closed_holes = 0;
};

// The last word about what is surface: drops what the photos contradict at its ends, closes small
// holes. A face is contradicted where there is texture, and it does not match through the face
// (`terms`, of this mesh; not looked at if border_cost is 0); it is dropped where that is worth the
// border which it makes (TrimSurface), and only if its piece reaches the border of the mesh:
// inside, the surface stays whole. Pieces of less than `min_component_faces` that this cuts off go,
// too. A manifold mesh stays manifold; one that is not is left as it is. Vertices without faces are
// removed. Deterministic. O(F log F).
FinishingSummary FinishSurface(const FacePairs& pairs, const PhotoTerms& terms,
                               const FinishingOptions& options, TriangleMesh* mesh,
                               const RunContext& context);

}  // namespace lsmvs
