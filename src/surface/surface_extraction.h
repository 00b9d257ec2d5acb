#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/surface/tetrahedralization.h"

namespace lsmvs {

// Facets of a cut complex as an oriented manifold.
struct ExtractedSurface {
  TriangleMesh mesh;  // canonical coordinates, positions only
  std::vector<int32_t>
      vertex_point;  // #mesh vertices: the complex' vertex; -1 at the middle of a split edge
  size_t num_cut_facets = 0;
  size_t num_split_vertices = 0;  // copies beyond the first, and middles of split edges
};

// The facets between a cell on the source's side (empty) and one that is not (full),
// counter-clockwise seen from the empty one; facets between two cells at infinity are not part of
// it, so the surface is open where the full space reaches the hull. Where more than two facets meet
// in an edge, those stay together that bound the same full cells; a vertex is copied for each fan
// of facets; an edge that is still shared by more than one pair is split in its middle, once for
// each further pair, which moves in by a hundredth of the shortest edge there, so that rounding
// does not take it through the others. So the result is manifold, geometrically the whole of the
// cut, and free of self-intersections (it may touch itself). Order: independent of that of the
// cells: vertices by the complex' vertices, faces by their vertices. O(n log n). Frees the cells as
// soon as it can.
ExtractedSurface ExtractSurface(Tetrahedralization complex);

}  // namespace lsmvs
