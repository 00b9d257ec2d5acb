#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/texturing/candidates/face_candidates.h"

namespace lsmvs {

// Per face the position of its photo among its candidates; kNoSlot for faces without candidates.
using ViewSlots = std::vector<uint8_t>;  // #F
inline constexpr uint8_t kNoSlot = 255;

// What a choice of photos costs, in pixels at the highest density of each face (so that neither the
// unit of the world nor the tessellation matters):
//   sum over faces of area (1 - quality / best quality)
//   + seam_cost * sum over edges of length * V,
// V = 0 between equal photos, else min(1, 0.2 + difference of the two photos' colours at the edge /
// 32). The colour of a photo at an edge is the mean of its colours on the two faces, or that of the
// one that it shows: V is a metric at each edge, as expansion moves need it. Edges beside faces
// without candidates cost nothing. In integers, so that the metric holds exactly. Refers to its
// arguments.
class LabelEnergy {
 public:
  LabelEnergy(const TriangleMesh& mesh, const FaceNeighbors& neighbors,
              const FaceCandidates& candidates, double seam_cost);

  // Units of one square pixel.
  static constexpr int kUnit = 768;

  int32_t FaceCost(size_t face, size_t slot) const;
  // Of edge `side` of the face, which has a neighbour with candidates, between two views, each of
  // which is a candidate of one of the two faces.
  int32_t EdgeCost(size_t face, int side, int view_a, int view_b) const;
  // Of a labelling.
  int64_t Total(const ViewSlots& slots) const;

  // Square pixels of a face.
  double AreaPx(size_t face) const;
  // Length of an edge in pixels: mean of what the two faces say.
  double LengthPx(size_t face, int side) const;
  int ViewOf(const ViewSlots& slots, size_t face) const {
    return slots[face] == kNoSlot ? -1 : candidates_.Of(face)[slots[face]].view_idx;
  }

  const TriangleMesh& mesh() const { return mesh_; }
  const FaceNeighbors& neighbors() const { return neighbors_; }
  const FaceCandidates& candidates() const { return candidates_; }

 private:
  Eigen::Vector3i TwiceColorAt(size_t face, size_t other, int view_idx) const;

  const TriangleMesh& mesh_;
  const FaceNeighbors& neighbors_;
  const FaceCandidates& candidates_;
  double seam_cost_;
};

// Each face's best photo.
ViewSlots BestSlots(const FaceCandidates& candidates);

}  // namespace lsmvs
