#pragma once

#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct NormalFilterOptions {
  int num_passes = 2;
  // Normals that differ by much less than this (distance of unit vectors; 0.35: 20 degrees) are
  // averaged, those that differ by much more lie on two sides of an edge.
  double normal_difference = 0.35;
};

// Takes noise off a surface and leaves its edges sharp. Each pass averages the normals of the faces
// that share a vertex with a face, those alike more than others, and moves the vertices until the
// faces have these normals. Which normals are alike is told by guides: that of a face is the mean
// normal of the most even of the patches (a face and those that share a vertex with it) around it,
// so that noise of the size of the faces does not pass for edges. Single spikes sink. Faces that
// noise had turned over may turn back.
//
// Vertex v moves by `limits[v]` (#V, world units; >= 0) at most. Vertices on borders and at edges
// that do not have two faces stay. Nothing is done against faces that cross afterwards. Colours,
// normals and quality are left as they are. Scale-free, does not depend on threads; O(#F) a pass
// where vertices have few faces, 1 us a face. Memory: 55 bytes per vertex and 60 bytes per face.
//   W. Zhang, B. Deng, J. Zhang, S. Bouaziz, L. Liu: Guided mesh normal filtering, Pacific Graphics
//   2015 (we judge a patch by the mean deviation of its normals); X. Sun, P. Rosin, R. Martin, F.
//   Langbein: Fast and effective feature-preserving mesh denoising, TVCG 13(5), 2007 (vertices).
void FilterNormals(const NormalFilterOptions& options, const std::vector<double>& limits,
                   const RunContext& context, TriangleMesh* mesh);

// The length of the shortest edge at each vertex (#V); infinite without faces. O(#F).
std::vector<double> ShortestEdges(const TriangleMesh& mesh);

}  // namespace lsmvs
