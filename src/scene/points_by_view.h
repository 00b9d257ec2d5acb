#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/scene/scene.h"

namespace lsmvs {

// Positions in scene.points of the points that each view sees, ascending: 4 bytes an observation.
class PointsByView {
 public:
  explicit PointsByView(const Scene& scene);

  std::span<const uint32_t> Of(int view_idx) const {
    const auto v = static_cast<size_t>(view_idx);
    return std::span(point_idxs_).subspan(begins_[v], begins_[v + 1] - begins_[v]);
  }

 private:
  std::vector<size_t> begins_;
  std::vector<uint32_t> point_idxs_;
};

}  // namespace lsmvs
