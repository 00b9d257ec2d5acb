#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/texturing/labels/view_labels.h"

namespace lsmvs {

// Small parts of the surface that show what the photo of the faces around has at their place,
// though it does not see them: folds of a rough mesh that no photo sees, smaller than 64 square
// pixels, and regions of a photo of less than 4. They need no chart of their own. A part joins the
// view beside it with the longest border, if all its faces project to that photo and are smaller
// than 8 pixels there. `views`: #F, of all faces, -1: none; becomes -1 for guests. Returns per face
// the view that it is a guest of, -1 for the others. O(#F log #F).
std::vector<int32_t> FindGuests(const Scene& scene, const LabelEnergy& energy,
                                std::vector<int32_t>* views);

}  // namespace lsmvs
