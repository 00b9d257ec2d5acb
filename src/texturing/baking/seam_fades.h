#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/texturing/labels/view_labels.h"
#include "lsmvs/texturing/levelling/label_nodes.h"

namespace lsmvs {

// Part of a photo in the colour of a vertex.
struct PhotoShare {
  int32_t view_idx = -1;
  float weight = 0;                                  // in [0, 1]
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();  // levelling of that photo, grey levels
};

// How photos are mixed at vertices near seams. Where a vertex has shares, all faces around it show
// the same mix there, whatever their label: colours go on over the seam.
struct SeamFades {
  std::vector<uint32_t> begin;  // #V + 1
  std::vector<PhotoShare> shares;

  // In the order of the views; weights sum to 1. Empty: each face shows its own photo.
  std::span<const PhotoShare> Of(size_t vertex) const {
    return {shares.data() + begin[vertex], begin[vertex + 1] - begin[vertex]};
  }
};

// A photo weighs 1 at vertices of its own faces, less with the distance from them along edges, 0 at
// `width_px` pixels; the weights of a vertex are scaled to a sum of 1. A photo that does not show
// all faces around a vertex, or far worse than their own photos do, has no weight there: at a seam
// that one photo alone sees to both sides, that photo is shown on both. Where a photo differs from
// the faces' own by more than 16 grey levels (after levelling), it fades within a quarter of the
// width: enough to hide the edge, too little for a double image. `offsets`: of the nodes
// (LevelSeams). O(#F) and O(log) per vertex near a seam. Deterministic.
SeamFades FindSeamFades(const LabelEnergy& energy, const LabelNodes& nodes,
                        const std::vector<Eigen::Vector3f>& offsets, double width_px);

}  // namespace lsmvs
