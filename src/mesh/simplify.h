#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct SimplifiedMesh {
  TriangleMesh mesh;
  // For each vertex the input vertex that it takes the place of: the nearest, as far as known.
  // CarryToSimplified() takes any value of a vertex along.
  std::vector<int> source_vertex;
};

// A mesh of about `max_faces` faces (a few more only if nothing else can be collapsed) that looks
// like the input: for display, not for measuring. Edges are collapsed in the order of their quadric
// error (Garland and Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH
// 1997), borders are held by planes across them, and no collapse turns a face over or makes an edge
// non-manifold that was not. Inputs of more than 16 times as many faces are first thinned on a
// grid. Any input will do: non-manifold, with faces that are degenerate or not finite (they are
// dropped). Already small meshes only lose those and unused vertices. Colours are those of the
// source vertices; normals are dropped. Deterministic. O(F log F), about 300 bytes per face of what
// is collapsed.
SimplifiedMesh SimplifyMesh(const TriangleMesh& mesh, size_t max_faces, const RunContext& context);

// The same without thinning, for parts of a larger mesh: vertices with `is_locked` (#V) stay, with
// all edges between them, so that the parts fit together as before. Other borders may move.
SimplifiedMesh SimplifyMeshPart(const TriangleMesh& mesh, const std::vector<uint8_t>& is_locked,
                                size_t max_faces, const RunContext& context);

struct BoundedSimplificationOptions {
  // Stops when this share of the faces is left, although the tolerance allows fewer.
  double target_face_ratio = 0;
  // Weight of keeping the border's course, relative to that of the faces, in the order of
  // collapses.
  double boundary_weight = 20;
  // Vertices take the colour that the input has at their place; otherwise that of their source
  // vertex.
  bool interpolate_colors = true;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// As few faces as edge collapses find that keep the surface within `tolerance` (#V of the input,
// >= 0, in units of the world) of the input. It is fastest where vertices that are near each other
// follow each other in the input.
//
// Up to rounding (about 1e-15 of the coordinates) and to 1 % of the tolerance, which is kept for
// the rounding of new vertices to single precision:
// - Every vertex and every point of an edge of the input is within tolerance of the output, and
//   every vertex of the output within that of the input. This is proven for each collapse.
// - Points on edges and faces of the output are tested at their middle and thirds, against nine
//   tenths of the tolerance. Points inside faces of the input are not tested: their edges are. On
//   real surfaces of a million faces with noise some 5 of a million points exceed the tolerance, by
//   up to a fifth.
// - Every point of the border has a point of the border of the output within tolerance, and the
//   other way round. Border vertices of the output are border vertices of the input.
// - Manifold parts stay manifold and oriented, of the same topology. Edges with other than one or
//   two faces of opposite direction, and vertices whose faces form more than one fan, stay.
// - No face turns by more than about 75 degrees in a step, and none is flatter than 1:20, unless it
//   was.
// - Faces cross nowhere where those of the input did not.
// Vertices without faces and faces that are degenerate by their indices or not finite are dropped.
// Colours are those of the input at the new place (they may be fewer than the photos would give:
// colour them anew), qualities those of the nearest vertex of the input; normals are computed anew
// where the input has any. Deterministic for any
// number of threads. About 10 microseconds and 400 bytes per face of the input. Throws
// UsageError for options that fail Check().
SimplifiedMesh SimplifyWithinTolerance(const TriangleMesh& mesh,
                                       const std::vector<double>& tolerance,
                                       const BoundedSimplificationOptions& options,
                                       const RunContext& context);

// Values of the input's vertices (#V of the input, or empty) for those of the output.
template <class Value>
std::vector<Value> CarryToSimplified(const SimplifiedMesh& simplified,
                                     const std::vector<Value>& values) {
  std::vector<Value> carried;
  if (values.empty()) return carried;
  carried.reserve(simplified.source_vertex.size());
  for (const int v : simplified.source_vertex) carried.push_back(values[static_cast<size_t>(v)]);
  return carried;
}

}  // namespace lsmvs
