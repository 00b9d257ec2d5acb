#include "lsmvs/mesh/surface_trimming.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

// Capacity that stands for one pixel of border or one square pixel of area.
constexpr double kCapacityPerPixel = 16;
// Capacities of a face and its three sides may be added up in 32 bits.
constexpr double kMaxCapacity = CutNode::kMaxCapacity / 4;

int32_t Capacity(double pixels) {
  return static_cast<int32_t>(std::clamp(kCapacityPerPixel * pixels, -kMaxCapacity, kMaxCapacity));
}

int32_t BorderCapacity(const TriangleMesh& mesh, const TrimmingProblem& problem, int a, int b) {
  const double length = (mesh.vertices[a] - mesh.vertices[b]).norm();
  const double pixel = 0.5 * (problem.pixel_size[a] + problem.pixel_size[b]);
  return pixel > 0 ? Capacity(problem.border_cost * length / pixel) : 0;
}

// Kept faces are on the source's side.
std::vector<CutNode> BuildGraph(const TriangleMesh& mesh, const TrimmingProblem& problem) {
  std::vector<CutNode> nodes(mesh.faces.size());
  for (size_t f = 0; f < nodes.size(); ++f) nodes[f].excess = Capacity(problem.keep_gain[f]);
  const std::vector<HalfEdge> sides = SortedHalfEdges(mesh.faces, mesh.vertices.size());
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    const int32_t capacity = BorderCapacity(mesh, problem, begin->low, begin->high);
    if (end - begin != 2) {
      for (const HalfEdge* side = begin; side != end; ++side) nodes[side->face].excess -= capacity;
      return;
    }
    for (int k = 0; k < 2; ++k) {
      const HalfEdge &here = begin[k], &there = begin[1 - k];
      CutNode& node = nodes[here.face];
      node.neighbor[here.corner] = there.face;
      node.capacity[here.corner] = capacity;
      node.SetReverse(here.corner, there.corner);
    }
  });
  return nodes;
}

// Connected pieces of dropped faces.
class DroppedPieces {
 public:
  DroppedPieces(const TriangleMesh& mesh, const std::vector<uint8_t>& visible,
                const std::vector<uint8_t>& kept)
      : pieces_(kept.size()), reaches_border_(kept.size(), 0), visible_area_(kept.size(), 0.0) {
    const std::vector<HalfEdge> sides = SortedHalfEdges(mesh.faces, mesh.vertices.size());
    ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
      if (end - begin == 2 && !kept[begin[0].face] && !kept[begin[1].face]) {
        pieces_.Unite(Number(begin[0].face), Number(begin[1].face));
      }
    });
    ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
      if (end - begin == 2) return;
      for (const HalfEdge* side = begin; side != end; ++side) {
        if (!kept[side->face]) reaches_border_[pieces_.Find(Number(side->face))] = 1;
      }
    });
    for (size_t f = 0; f < kept.size(); ++f) {
      if (kept[f]) continue;
      const double area = FaceNormalTimesTwiceArea(mesh, f).norm();
      visible_area_[PieceOf(f)] += visible.empty() || visible[f] ? area : -area;
    }
  }

  bool IsEnclosed(size_t face) { return reaches_border_[PieceOf(face)] == 0; }
  bool IsVisible(size_t face) { return visible_area_[PieceOf(face)] >= 0; }

 private:
  static uint32_t Number(int32_t face) { return static_cast<uint32_t>(face); }
  uint32_t PieceOf(size_t face) { return pieces_.Find(static_cast<uint32_t>(face)); }

  DisjointSets pieces_;
  // By the piece's first face; area that can be seen minus the rest.
  std::vector<uint8_t> reaches_border_;
  std::vector<double> visible_area_;
};

}  // namespace

std::vector<uint8_t> TrimSurface(const TriangleMesh& mesh, const TrimmingProblem& problem,
                                 const RunContext& context) {
  std::vector<CutNode> nodes = BuildGraph(mesh, problem);
  MaximizeFlow(&nodes, context);
  std::vector<uint8_t> kept(nodes.size());
  for (size_t f = 0; f < nodes.size(); ++f) kept[f] = nodes[f].OnSourceSide();
  return kept;
}

size_t KeepEnclosedFaces(const TriangleMesh& mesh, const std::vector<uint8_t>& visible,
                         std::vector<uint8_t>* kept) {
  DroppedPieces pieces(mesh, visible, *kept);
  size_t num_kept = 0;
  for (size_t f = 0; f < kept->size(); ++f) {
    if ((*kept)[f] || !pieces.IsEnclosed(f) || !pieces.IsVisible(f)) continue;
    (*kept)[f] = 1;
    ++num_kept;
  }
  return num_kept;
}

}  // namespace lsmvs
