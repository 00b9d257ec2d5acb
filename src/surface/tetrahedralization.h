#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// A tetrahedron, and at the same time a node of the graph that is cut: one cache line holds all
// that a step of the ray walk or of the cut needs. Facet i lies opposite vertex i and leads to
// CutNode::neighbor[i].
struct alignas(64) Cell : CutNode {
  static constexpr int32_t kInfiniteVertex = -1;
  // Positively oriented: (v1-v0) x (v2-v0) points to v3's side. One is kInfiniteVertex in the cells
  // outside of the hull.
  std::array<int32_t, 4> vertex = {};

  int IndexOfVertex(int32_t v) const {
    return vertex[0] == v ? 0 : vertex[1] == v ? 1 : vertex[2] == v ? 2 : 3;
  }
};
static_assert(sizeof(Cell) == 64);

// The vertices of facet i in the order in which they are counter-clockwise seen from inside of the
// cell.
inline constexpr std::array<std::array<int, 3>, 4> kFacetVertices = {
    {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

// Delaunay tetrahedralisation in flat arrays. Cells [0, num_finite_cells) are tetrahedra, the
// others have the infinite vertex: one for each facet of the hull.
struct Tetrahedralization {
  std::vector<Eigen::Vector3f> points;  // #V, the vertices
  std::vector<Cell> cells;
  size_t num_finite_cells = 0;
  std::vector<int32_t>
      incident_cell;  // #V: a finite cell of each vertex; -1 if an equal point came before it
  // (vertex, the equal vertex that stands for it), ascending
  std::vector<std::array<int32_t, 2>> duplicates;

  bool IsInfinite(int32_t cell) const { return static_cast<size_t>(cell) >= num_finite_cells; }
};

// Builds the complex. Points should come in an order of which neighbours are close (HilbertOrder).
// Empty cells if fewer than four points are different or all are in one plane. Exact: no tolerance
// anywhere. Deterministic. Works in one thread; throws CancelledError.
Tetrahedralization BuildDelaunay(std::vector<Eigen::Vector3f> points,
                                 const RunContext& context = RunContext(1));

// The tetrahedron that holds x, or a cell at infinity that sees it. Exact. Walks from the cell
// `start`: fast if that is near. The complex is not empty.
int32_t LocateCell(const Tetrahedralization& complex, const Eigen::Vector3f& x, int32_t start);

}  // namespace lsmvs
