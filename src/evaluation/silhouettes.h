#pragma once

#include <cstddef>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// How torn a mesh looks from the poses of the photos. Lower is better, but for `coverage`; read
// them beside the coverage: what is sky must stay open.
struct SilhouetteFigures {
  size_t num_views =
      0;                // in which the mesh covers at least 100 pixels; the figures are their means
  double coverage = 0;  // share of the pixels that the mesh covers
  // As parts of the pixels that the mesh covers:
  double hole_share =
      0;  // background enclosed by the mesh, in parts of less than 5 % of the picture
  double torn_share = 0;  // background that a closing by a disc of 1 % of the width fills
  // Pixels whose normal is more than 45 degrees off the mean normal of the 9 x 9 pixels around:
  // lumps and noise, and true edges.
  double crumb_share = 0;
  // Length of the silhouette's edge over the square root of the covered pixels: a disc has 4.5.
  double rim = 0;
};

// Looks at the mesh from every view at a size of 1 / `reduction` of the photo. `tracer` is that of
// `mesh`. Deterministic. O(#views * pixels).
SilhouetteFigures MeasureSilhouettes(const MeshTracer& tracer, const TriangleMesh& mesh,
                                     const std::vector<View>& views, const RunContext& context,
                                     double reduction = 4);

}  // namespace lsmvs
