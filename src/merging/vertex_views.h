#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Views that see vertex v: view_idxs[view_begin[v] .. view_begin[v+1]), ascending.
struct VertexViews {
  std::vector<uint64_t> view_begin;
  std::vector<uint32_t> view_idxs;
};

// For a mesh of which only the cameras are known: a view sees the vertices in its image that turn
// their front to it and that no other face hides, by a depth map of reduced size. Deterministic for
// any number of threads. O(#views (#V + #F)); 4 bytes a sight, and a depth map.
VertexViews FindVertexViews(const TriangleMesh& mesh, std::span<const View> views,
                            const RunContext& context);

// The camera of at most about 1,000 pixels in width and height with which views are drawn.
PinholeCamera DrawingCamera(const PinholeCamera& camera);

}  // namespace lsmvs
