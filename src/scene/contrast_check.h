#pragma once

#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Decodes all photos and warns of those without contrast (black frames, a lens cap, few bits of
// many), with their ranges of grey; masked pixels do not count. Throws InputError if none has
// contrast. Cheap beside matching.
void CheckContrast(const Scene& scene, const ImageStore& images, const RunContext& context);

}  // namespace lsmvs
