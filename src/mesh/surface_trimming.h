#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What speaks for and against the faces of a surface.
struct TrimmingProblem {
  // #F: what is lost if the face is dropped, in square pixels of area times a log-likelihood ratio;
  // negative: what is lost if it is kept.
  std::vector<double> keep_gain;
  std::vector<double> pixel_size;  // #V: length in the world of one pixel at the vertex
  double border_cost = 0;          // per pixel of border of what is kept
};

// Labels the faces of a surface: 1 = kept, 0 = dropped. Minimises exactly
//   sum over dropped faces of keep_gain + border_cost * length in pixels of the border of what is
//   kept
// by a minimum cut on the graph of faces that share an edge. A face with evidence against it stays
// where its surroundings are well supported, because taking it out makes border; and the border of
// what is kept is short, without teeth. An edge of the mesh's own border counts where its face is
// kept. Raising border_cost closes larger gaps and shortens borders.
//
// The mesh must be manifold and oriented. Exact, in integers; deterministic. O(F log F) in
// practice; about 100 bytes per face. Throws CancelledError.
//   Y. Boykov, V. Kolmogorov: Computing geodesics and minimal surfaces via graph cuts, ICCV 2003.
std::vector<uint8_t> TrimSurface(const TriangleMesh& mesh, const TrimmingProblem& problem,
                                 const RunContext& context);

// Keeps dropped faces after all where they lie inside of the surface: connected pieces of dropped
// faces (across edges) that do not reach the mesh's own border, and of which more area can be seen
// (`visible`, #F; empty: all) than not. Returns the number of faces kept. O(F).
size_t KeepEnclosedFaces(const TriangleMesh& mesh, const std::vector<uint8_t>& visible,
                         std::vector<uint8_t>* kept);

}  // namespace lsmvs
