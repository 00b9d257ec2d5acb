#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Copies vertices until the faces at each form one fan, and edges with more than two faces have
// none in common: afterwards the mesh is manifold. No face is lost, nothing moves; at an edge with
// more than two faces all part. Copies are appended, in the order of their faces, with colour and
// normal; returns for each the vertex it copies. Faces must be oriented alike. O(F log F).
std::vector<int> SplitNonManifoldVertices(TriangleMesh* mesh);

// Connected parts.
struct MeshComponents {
  std::vector<int> of_face;       // #F, numbered in the order of their first faces
  std::vector<size_t> num_faces;  // per component
};

// Components connected over shared vertices. O(F).
MeshComponents FindComponents(const TriangleMesh& mesh);

// Keeps the faces for which `keep(face)` holds, in order; vertices stay. Returns the number
// dropped.
size_t FilterFaces(TriangleMesh* mesh, const std::function<bool(size_t face)>& keep);

// Closed loops of border edges, each in the direction in which new faces would run along it; the
// mesh must be manifold. Loops in the order of their lowest vertex, which comes first.
std::vector<std::vector<int>> FindBorderLoops(const TriangleMesh& mesh);

struct HoleClosingOptions {
  int max_num_edges = 40;
  // Whether a face may be added; without it all may. If there is no way to close a hole, it stays.
  std::function<bool(const Eigen::Vector3i& face)> accept;
};

// Closes small holes by triangles between the vertices of their borders, of least total area. A
// hole stays open if every way to close it would repeat an edge of the mesh or need a face that
// is not accepted, or if the best way passes through other faces. Adds no vertices. Returns the
// number of closed holes. O(h^3) for a hole of h edges, and O(F) for looking for crossings.
size_t CloseHoles(const HoleClosingOptions& options, const RunContext& context, TriangleMesh* mesh);

}  // namespace lsmvs
