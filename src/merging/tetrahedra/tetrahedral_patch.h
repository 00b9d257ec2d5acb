#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/merging/overlap/free_space.h"
#include "lsmvs/merging/overlap/mesh_band.h"
#include "lsmvs/merging/seam/surface_merging.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct TetrahedralPatchOptions {
  // Edge lengths within which two surfaces are taken for the same one.
  double max_edges = 6;
  // Where both meshes contradict each other; the nearest one says which of them counts. Where there
  // are none the first one does.
  std::span<const ConflictPoint> conflicts;
  // Views of the meshes' vertices; empty, or a vertex without: not known.
  std::span<const View> views;
  VisitViews visit_views;
};

// The parts of two meshes (#F each) through which a new surface is to be made.
using PatchFaces = std::array<std::vector<uint8_t>, 2>;

// A new surface through the vertices of both meshes' parts (thesis, 5.2.2): they are
// tetrahedralised (Delaunay), each tetrahedron is labelled outside or inside by a minimum cut, and
// the facets between both are the surface. A tetrahedron is drawn to the side of each mesh on which
// it lies, by the oriented face that is nearest to it, the finer mesh more; facets cost their area,
// less where they are faces of a mesh, more where they lie far from both. Where views are known,
// what they saw counts as in visibility_mesher.h: the space between a vertex and the photos that
// see it is outside, and a bit behind it is inside. So where one mesh is
// alone, the surface is that mesh wherever its faces are Delaunay, and near it elsewhere; where
// both agree it follows the finer one; where they do not, it changes over where they come closest,
// or along the least wall.
//
// The result is manifold and does not cross itself, up to the rounding of the tetrahedralisation's
// single precision. It ends some edge lengths before the parts do, so that it can be joined there
// with the rest of the meshes; it does not go beyond where both meshes end. Positions are bit for
// bit those of the meshes. May be empty. About 0.7 kB and 0.1 ms a vertex. Deterministic.
SourcedMesh MakeTetrahedralPatch(const SourcedMesh& first, const SourcedMesh& second,
                                 const PatchFaces& faces, const TetrahedralPatchOptions& options,
                                 const RunContext& context);

}  // namespace lsmvs
