#pragma once

#include <cstddef>

#include "lsmvs/texturing/labels/view_labels.h"

namespace lsmvs {

// Gives regions of one photo that are smaller than `min_area_px` square pixels to the neighbouring
// photo with the longest common border that shows all of their faces; the smallest first. Regions
// that no neighbour shows as a whole stay. Returns how many were given away.
size_t AbsorbIslands(const LabelEnergy& energy, double min_area_px, ViewSlots* slots);

}  // namespace lsmvs
