#pragma once

#include <cstddef>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct SimplifiedMesh {
  TriangleMesh mesh;               // colours are those of the source vertices; normals are dropped
  std::vector<int> source_vertex;  // for each vertex the nearest one of the input that it replaces
};

// A mesh of about `max_faces` faces (a few more only if nothing else can be collapsed) that looks
// like the input: for display, not for measuring. Edges are collapsed in the order of their quadric
// error (Garland and Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH
// 1997), borders are held by planes across them, and no collapse turns a face over or makes an edge
// non-manifold that was not. Inputs of more than 16 times as many faces are first thinned on a
// grid. Any input will do: non-manifold, with faces that are degenerate or not finite (they are
// dropped). Already small meshes only lose those and unused vertices. Deterministic. O(F log F),
// about 600 bytes a face of what is collapsed.
SimplifiedMesh SimplifyMesh(const TriangleMesh& mesh, size_t max_faces, const RunContext& context);

}  // namespace lsmvs
