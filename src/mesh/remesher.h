#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// A triangle mesh that can be split, flipped and collapsed, with a second position of every vertex
// (`rest`) that goes along: where the vertex lies on the surface that the mesh was made from. Every
// operation keeps manifold parts manifold and oriented, adds no degenerate face, and leaves borders
// where they are. Edges with more than two faces, vertices whose faces form more than one fan and
// pairs of faces with the same three corners are locked: nothing is done to them.
//
// `density` (#F) turns areas into what the caller counts in: square pixels per square of the
// world's unit; 0 where a face should not be split or thinned out. Halves of a face take its
// density.
//
// Of a mesh whose neighbouring faces have neighbouring numbers, it works on one part after the
// other.
class Remesher {
 public:
  Remesher(const TriangleMesh& mesh, std::vector<Eigen::Vector3d> rest, std::vector<float> density);

  // Keeps the surface around these vertices (of the mesh it was made from) as it is: edges there
  // are neither flipped nor collapsed. They may still be split, which changes no surface.
  void Lock(const std::vector<int32_t>& vertices);

  // Bisects longest edges until no face with a density is larger than `max_area` (in the density's
  // unit), in `max_passes` at most. Neighbours of a split edge are split with it, whatever their
  // density. Returns the number of edges split.
  size_t SplitLargeFaces(double max_area, int max_passes = 8);

  // Collapses edges between faces with a density that are shorter than `min_length` (in units of 1
  // / sqrt(density)) where the surface moves by less than `max_deviation` (same unit), no face
  // turns by more than about 25 degrees and no edge becomes longer than 2 * min_length. Returns the
  // number of edges collapsed.
  size_t CollapseShortEdges(double min_length, double max_deviation);

  // Flips edges whose opposite angles sum to more than 180 degrees (Delaunay), where the four
  // corners are nearly in a plane: the surface moves by less than `max_deviation` in units of 1 /
  // sqrt(density), or not at all where there is no density.
  size_t FlipToDelaunay(double max_deviation, int max_passes = 4);

  TriangleMesh Mesh() const;                  // without deleted elements
  std::vector<Eigen::Vector3d> Rest() const;  // as the vertices of Mesh()
  // As the vertices of Mesh(): the same vertex of the mesh it was made from, or, of those that a
  // split made, a vertex of the edge that was split.
  std::vector<int32_t> Origins() const;

 private:
  static constexpr int32_t kBorder = -1;

  struct Face {
    std::array<int32_t, 3> v;
    // across[k]: the face at the edge from v[k] to v[k + 1], or kBorder.
    std::array<int32_t, 3> across;
    float density;
    bool deleted = false;
  };

  // Calls work(begin, end) for the blocks of the faces that are there.
  template <class Work>
  void ForBlocks(const Work& work);
  size_t SplitInBlock(size_t begin, size_t end, double max_area);
  size_t CollapseInBlock(size_t begin, size_t end, double min_length, double max_deviation);
  // #V: whether a face that is left uses the vertex.
  std::vector<uint8_t> UsedVertices() const;
  void LinkFaces(const TriangleMesh& mesh);
  void LockIrregularVertices();
  int CornerOf(int32_t face, int32_t vertex) const;
  // Sets what lies across the edge of `face` that starts at vertex `start`.
  void SetAcross(int32_t face, int32_t start, int32_t to);
  double Area(const Face& face) const;
  double EdgeLength(const Face& face, int edge) const;
  int LongestEdge(const Face& face) const;
  bool IsLocked(const Face& face, int edge) const;
  void SplitEdge(int32_t face, int edge);
  bool WantsFlip(int32_t face, int edge, double max_deviation) const;
  // The two faces at an inner edge ab: f = abc and n = bad, and what lies across their other edges.
  struct EdgeSides {
    int32_t n, a, b, c, d, across_bc, across_ca, across_ad, across_db;
  };
  EdgeSides SidesOf(int32_t f, int k) const;
  void FlipEdge(int32_t face, int edge);
  // Faces around a vertex, counter-clockwise; false at borders and locked vertices.
  bool Fan(int32_t vertex, std::vector<int32_t>* faces) const;
  bool MayCollapse(int32_t face, int edge, double min_length, double max_deviation);
  void CollapseEdge(int32_t face, int edge);
  bool KeepsShape(int32_t moved, int32_t other, const Eigen::Vector3d& to,
                  const std::vector<int32_t>& fan, double max_length, double max_deviation) const;

  std::vector<Eigen::Vector3d> positions_, rest_;
  std::vector<Face> faces_;
  std::vector<int32_t> origins_;    // #V
  std::vector<int32_t> face_of_;    // #V: one face of the vertex, or kBorder
  std::vector<uint8_t> locked_;     // #V
  std::vector<uint8_t> on_border_;  // #V
  std::vector<int32_t> fan_a_, fan_b_;
};

}  // namespace lsmvs
