#pragma once

#include <algorithm>
#include <cstddef>

namespace lsmvs {

// Mean of the longer sides of the images of views, or of whatever else has a `camera`; pixels, 0
// without any.
template <class Views>
double MeanLongerSide(const Views& views) {
  double sum = 0;
  for (const auto& view : views) sum += std::max(view.camera.width, view.camera.height);
  return sum / static_cast<double>(std::max<size_t>(views.size(), 1));
}

}  // namespace lsmvs
