#pragma once

#include <cstddef>

#include "lsmvs/texturing/labels/view_labels.h"

namespace lsmvs {

// Gives regions of one photo that are smaller than `min_area_px` square pixels to the neighbouring
// photo with the longest common border that shows all of their faces; the smallest first. Of
// regions that no neighbour shows as a whole, faces go one by one to the photos beside that show
// them, and the rest stays. Returns how many regions were given away as a whole.
size_t AbsorbIslands(const LabelEnergy& energy, double min_area_px, ViewSlots* slots);

}  // namespace lsmvs
