#pragma once

#include <cstddef>

#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/texturing/candidates/face_candidates.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Drops candidates that show something else than the other photos of the face: who walked by, an
// occluder that the mesh lacks, a highlight. Of faces with three candidates or more: how far a
// candidate's colour lies from the weighted median, in units of the median absolute deviation (4
// grey levels at least), averaged over the faces around that the same photo shows. What lies
// further off than 4 units is dropped, with what hangs on it at half as much, and a ring of faces
// more; never the last candidate of a face. Returns how many were dropped. Sequence of sweeps over
// the faces; deterministic. O(candidates); 2 bytes a candidate.
size_t DropGhosts(const FaceNeighbors& neighbors, FaceCandidates* candidates,
                  const RunContext& context);

}  // namespace lsmvs
