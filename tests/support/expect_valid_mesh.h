#pragma once

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// What every mesh that we hand out must be: not empty, finite, manifold edges and vertices,
// consistently oriented, no degenerate, duplicate or unused element, attributes that fit. Fails the
// test otherwise, naming what is wrong.
void ExpectValidMesh(const TriangleMesh& mesh);
// The same, and without border.
void ExpectValidClosedMesh(const TriangleMesh& mesh);

}  // namespace lsmvs
