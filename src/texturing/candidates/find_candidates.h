#pragma once

#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/texturing/candidates/face_candidates.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// The photos that show each face, at most `max_per_face`. A photo shows a face if
// - it sees its front at 3 degrees or more from edge-on,
// - at all sample points of the face the photo has a pixel that may be used (FindValidPixels), and
//   nothing is nearer there than the face by more than 12 pixels' widths: less is the roughness of
//   the mesh. More than 2 makes the photo doubtful.
// Sample points are the corners drawn in, the middles of the edges and the centroid, or, where the
// face is larger than 8 pixels, a lattice of 4 pixels. Doubtful photos count a tenth. A photo less
// sharp than another of the same face counts less.
// One photo at a time per thread: 12 bytes per pixel, and 20 bytes per face that it shows. O(#V +
// #F) per photo. Deterministic.
FaceCandidates FindCandidates(const Scene& scene, const ImageStore& images,
                              const TriangleMesh& mesh, int max_per_face,
                              const RunContext& context);

}  // namespace lsmvs
