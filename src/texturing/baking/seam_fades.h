#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/texturing/labels/view_labels.h"
#include "lsmvs/texturing/levelling/seam_levelling.h"

namespace lsmvs {

// At a node near a seam: the photo beyond it, which is mixed in.
struct SeamFade {
  int32_t view_idx = -1;
  float weight = 0;                                  // of that photo, in [0, 0.5]
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();  // levelling of that photo, grey levels
};

// Fades from one half at a seam to nothing at `width_px` pixels along the edges of the region. None
// where a face around does not show in the other photo, or where the two photos differ by more than
// 16 grey levels there (after levelling): to mix them would give a double image. Per node.
std::vector<SeamFade> FindSeamFades(const LabelEnergy& energy, const LabelNodes& nodes,
                                    const std::vector<SeamPair>& pairs,
                                    const std::vector<Eigen::Vector3f>& offsets, double width_px);

}  // namespace lsmvs
