#pragma once

#include <numeric>
#include <vector>

#include "lsmvs/scene/scene.h"

namespace lsmvs {

// The views that were named, or all if none was.
inline std::vector<int> NamedViewsOrAll(const std::vector<int>& view_idxs, const Scene& scene) {
  if (!view_idxs.empty()) return view_idxs;
  std::vector<int> all(scene.views.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace lsmvs
