#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/texturing/labels/view_labels.h"
#include "lsmvs/texturing/levelling/label_nodes.h"

namespace lsmvs {

struct LevellingOptions {
  // A step of colour across a seam costs as much as its square over this many pixels. More is
  // softer.
  double seam_width_px = 16;
  // Distance in pixels over which colours return to the mean of all photos.
  double screening_px = 128;
};

// Where two photos meet: two nodes of a vertex, joined by edges of the seam.
struct SeamPair {
  int32_t first, second;  // nodes, first < second
  float length_px;        // of the seam's edges at the vertex, half of each
  // Mean colour of the first photo less that of the second on the faces around that both show.
  Eigen::Vector3f difference;
  bool is_known;  // whether there is such a face
};

// In the order of `first`, then `second`.
std::vector<SeamPair> FindSeamPairs(const LabelEnergy& energy, const LabelNodes& nodes);

// Offsets in grey levels to add to the photos' colours, so that they meet without a step: per node
// the minimiser g of
//   sum over edges inside of regions |g_i - g_j|^2
//   + sum over seam pairs length / seam_width |g_first - g_second + difference|^2
//   + sum over nodes area / screening^2 |g - (mean of all candidates - own colour)|^2.
// Positive definite; by conjugate gradients without a stored matrix. 60 bytes per node.
//   After V. Lempitsky, D. Ivanov: Seamless mosaicing of image-based texture maps, CVPR 2007. The
//   screen is ours: without it, errors add up over many seams.
std::vector<Eigen::Vector3f> LevelSeams(const LabelEnergy& energy, const LabelNodes& nodes,
                                        const std::vector<SeamPair>& pairs,
                                        const LevellingOptions& options);

}  // namespace lsmvs
