#pragma once

#include <cstddef>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct MeshAdaptationOptions {
  double max_face_area_px = 16.0;  // larger faces are split; 0: none is
  bool collapse = true;            // short edges, see Remesher
  bool flip = true;
};

struct MeshAdaptation {
  size_t num_splits = 0, num_flips = 0, num_collapses = 0;
  bool Any() const { return num_splits + num_flips + num_collapses > 0; }
};

// Brings the triangles of a mesh to the resolution of the photos. `density` (#F): square pixels per
// square of the world's unit; 0 where a face should stay. `rest` (#V in, #V out): the input
// position of every vertex. Manifold where it was; the surface moves by a tenth of a pixel at most,
// and passes through itself nowhere where it did not before.
MeshAdaptation AdaptMesh(const MeshAdaptationOptions& options, const std::vector<float>& density,
                         TriangleMesh* mesh, std::vector<Eigen::Vector3d>* rest,
                         const RunContext& context);

}  // namespace lsmvs
