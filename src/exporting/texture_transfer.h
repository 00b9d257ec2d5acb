#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct TransferredTexture {
  std::vector<std::array<Eigen::Vector2f, 3>> texcoords;  // #F of the other mesh [px of the page]
  ColorImage page;
};

// The texture of a mesh on another mesh of the same surface (a simplified one, for display): each
// texel shows the mean colour of its size around the nearest point. One page of about `max_texels`
// or fewer: texels are not finer than those of the original. `tracer` is that of the textured mesh.
// Deterministic. About 3 microseconds per texel.
TransferredTexture TransferTexture(const TexturePages& pages, const MeshTracer& tracer,
                                   const TriangleMesh& mesh, double max_texels,
                                   const RunContext& context);

}  // namespace lsmvs
