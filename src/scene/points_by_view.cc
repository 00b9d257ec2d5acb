#include "lsmvs/scene/points_by_view.h"

#include <numeric>

namespace lsmvs {

PointsByView::PointsByView(const Scene& scene) : begins_(scene.views.size() + 1, 0) {
  for (const SparsePoint& point : scene.points) {
    for (const int v : point.view_idxs) ++begins_[static_cast<size_t>(v) + 1];
  }
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  point_idxs_.resize(begins_.back());
  std::vector<size_t> next = begins_;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    for (const int v : scene.points[p].view_idxs) {
      point_idxs_[next[static_cast<size_t>(v)]++] = static_cast<uint32_t>(p);
    }
  }
}

}  // namespace lsmvs
