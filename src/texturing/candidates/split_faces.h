#pragma once

#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Splits the edges that are longer than `max_width_px` in a photo that looks at the front of their
// face, at their middles, until none is left or there are far more faces than before: the surface
// stays the same, but each part of a large face may take the photo that sees it. Faces beside a
// split edge are split with it: no T-junctions. Old vertices keep their indices; faces that are not
// split come first, in their order. Returns the number of splits. O(#F #views), less where no photo
// comes near enough for long edges. Throws CancelledError.
size_t SplitWideFaces(const Scene& scene, const ImageStore& images, double max_width_px,
                      TriangleMesh* mesh, const RunContext& context);

}  // namespace lsmvs
