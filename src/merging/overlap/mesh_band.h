#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Where a vertex comes from: what it takes colour, quality and views from.
struct VertexSource {
  int32_t input = -1, vertex = -1;
  bool operator==(const VertexSource&) const = default;
};

// A mesh on its way through the merging: positions and faces; attributes stay with the sources.
struct SourcedMesh {
  TriangleMesh mesh;
  std::vector<VertexSource> sources;  // #V
  // #V: whether the vertex is new or was moved, or a face at it is new.
  std::vector<uint8_t> is_changed;
  // #V, or empty: none. Where several meshes are, the one with such vertices is kept.
  std::vector<uint8_t> is_preferred;
};

// The faces of a mesh that are worked on, as a mesh of their own.
struct MeshBand {
  TriangleMesh mesh;                  // positions and faces, in the order of the whole
  std::vector<VertexSource> sources;  // #V
  std::vector<uint8_t> is_changed;    // #V
  std::vector<uint8_t> is_preferred;  // #V
  std::vector<int32_t> whole_vertex;  // #V: in the whole mesh; -1: the band has added it
  std::vector<uint8_t> is_fixed;      // #V: faces outside of the band use it, too
  // Edges (lower vertex << 32 | higher) at which faces outside of the band meet the band's.
  std::vector<uint64_t> cut_edges;  // ascending
};

inline uint64_t EdgeKey(int32_t a, int32_t b) {
  const auto low = static_cast<uint64_t>(a < b ? a : b),
             high = static_cast<uint64_t>(a < b ? b : a);
  return low << 32 | high;
}

// The faces with `in_band` (#F). O(#V + #F).
MeshBand ExtractBand(const SourcedMesh& whole, const std::vector<uint8_t>& in_band);

// Neighbours of the vertices of a mesh and its borders.
class SurfaceTopology {
 public:
  // Border edges that are in `cut_edges` do not count as border. O(#V + #F).
  SurfaceTopology(const TriangleMesh& mesh, const std::vector<uint64_t>& cut_edges);

  // Calls visit(w) for each neighbour w of v.
  template <class Visit>
  void ForNeighbors(int32_t v, const Visit& visit) const {
    const auto i = static_cast<size_t>(v);
    for (uint32_t k = begin_[i]; k < begin_[i + 1]; ++k) visit(neighbors_[k]);
  }
  bool IsOnBorder(int32_t v) const { return on_border_[static_cast<size_t>(v)] != 0; }
  // From corner k of a face to the next: whether nothing lies across.
  bool IsBorderSide(int32_t face, int k) const {
    return border_sides_[static_cast<size_t>(face)] >> k & 1;
  }
  size_t num_vertices() const { return on_border_.size(); }

 private:
  std::vector<uint32_t> begin_;
  std::vector<int32_t> neighbors_;
  std::vector<uint8_t> on_border_;     // #V
  std::vector<uint8_t> border_sides_;  // #F, a bit per side
};

// Distances along edges from the vertices with a start distance (infinite elsewhere), as far as
// `max_distance`; infinite beyond. With `nearest` (#V): the start vertex each comes from, or -1.
std::vector<double> DistanceAlongEdges(const TriangleMesh& mesh, const SurfaceTopology& topology,
                                       std::vector<double> start, double max_distance,
                                       std::vector<int32_t>* nearest = nullptr);

// Size and direction of the surface at each vertex, smoothed over some rings.
struct VertexFrames {
  std::vector<double> edge_length;      // #V, > 0: mean length of the edges
  std::vector<Eigen::Vector3d> normal;  // #V, unit length
};
VertexFrames ComputeVertexFrames(const TriangleMesh& mesh, const SurfaceTopology& topology);

}  // namespace lsmvs
