#include "lsmvs/scene/visibility_cloud.h"

#include <algorithm>

#include "lsmvs/util/check.h"

namespace lsmvs {

void VisibilityCloud::Add(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                          const Color& color, std::span<const uint32_t> views) {
  positions.push_back(position);
  normals.push_back(normal);
  colors.push_back(color);
  const auto first = static_cast<std::ptrdiff_t>(view_idxs.size());
  view_idxs.insert(view_idxs.end(), views.begin(), views.end());
  std::sort(view_idxs.begin() + first, view_idxs.end());
  view_idxs.erase(std::unique(view_idxs.begin() + first, view_idxs.end()), view_idxs.end());
  view_begin.push_back(view_idxs.size());
}

void VisibilityCloud::Append(const VisibilityCloud& other) {
  const uint64_t base = view_idxs.size();
  positions.insert(positions.end(), other.positions.begin(), other.positions.end());
  normals.insert(normals.end(), other.normals.begin(), other.normals.end());
  colors.insert(colors.end(), other.colors.begin(), other.colors.end());
  view_idxs.insert(view_idxs.end(), other.view_idxs.begin(), other.view_idxs.end());
  for (size_t p = 1; p < other.view_begin.size(); ++p) {
    view_begin.push_back(base + other.view_begin[p]);
  }
}

void VisibilityCloud::Reserve(size_t num_points, size_t num_view_entries) {
  positions.reserve(num_points);
  normals.reserve(num_points);
  colors.reserve(num_points);
  view_begin.reserve(num_points + 1);
  view_idxs.reserve(num_view_entries);
}

void VisibilityCloud::CheckConsistent(size_t num_views) const {
  LSMVS_CHECK_EQ(normals.size(), positions.size());
  LSMVS_CHECK_EQ(colors.size(), positions.size());
  LSMVS_CHECK_EQ(view_begin.size(), positions.size() + 1);
  LSMVS_CHECK_EQ(view_begin.front(), uint64_t{0});
  LSMVS_CHECK_EQ(view_begin.back(), view_idxs.size());
  LSMVS_CHECK(std::is_sorted(view_begin.begin(), view_begin.end()));
  for (const uint32_t view_idx : view_idxs) LSMVS_CHECK_LT(view_idx, num_views);
}

}  // namespace lsmvs
