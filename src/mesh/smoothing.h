#pragma once

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct TaubinOptions {
  int num_iterations = 2;  // each a shrinking and an expanding step
  double lambda = 0.5;     // share of the way to the neighbours' mean in the shrinking step
  double mu = -0.53;       // and in the expanding step; |mu| a little above lambda keeps the volume
};

// Volume-preserving low-pass filter: vertices move towards the mean of their neighbours and back
// out. Scale-free. Border vertices stay. Normals, if any, are computed anew. O(F) an iteration.
//   G. Taubin: A signal processing approach to fair surface design, SIGGRAPH 1995.
void SmoothTaubin(const TaubinOptions& options, const RunContext& context, TriangleMesh* mesh);

}  // namespace lsmvs
