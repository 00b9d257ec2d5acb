#pragma once

#include <memory>

#include "lsmvs/image/image_store.h"
#include "lsmvs/refinement/mesh_refiner.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"
#include "lsmvs/util/shared_loop.h"

namespace lsmvs {

// What takes part in the loops of RefineMesh() in another process, with the same scene, photos and
// options: the choice of pairs, and the photo terms of each step, which are most of its time. Holds
// the mesh as it is at present, the photos and the depth maps that its items need, within the
// context's budget. It is sent 60 bytes a face at each change of the triangles, 60 at each step,
// and sends back, of each view, 40 bytes for each face that the view shows.
std::unique_ptr<LoopWorker> MakeRefinementWorker(const Scene& scene, const ImageStore& images,
                                                 const MeshRefinerOptions& options,
                                                 const RunContext& context);

}  // namespace lsmvs
