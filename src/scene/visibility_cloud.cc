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

void VisibilityCloud::KeepIf(const std::function<bool(size_t point)>& keep) {
  size_t num_kept = 0;
  uint64_t num_entries = 0;
  for (size_t p = 0; p < size(); ++p) {
    if (!keep(p)) continue;
    // What is kept moves down: nothing from p on is overwritten.
    const uint64_t begin = view_begin[p], end = view_begin[p + 1];
    positions[num_kept] = positions[p];
    normals[num_kept] = normals[p];
    colors[num_kept] = colors[p];
    view_begin[num_kept++] = num_entries;
    for (uint64_t i = begin; i < end; ++i) view_idxs[num_entries++] = view_idxs[i];
  }
  const auto shrink = [](auto* values, size_t count) {
    values->resize(count);
    values->shrink_to_fit();
  };
  shrink(&positions, num_kept);
  shrink(&normals, num_kept);
  shrink(&colors, num_kept);
  shrink(&view_begin, num_kept + 1);
  view_begin.back() = num_entries;
  shrink(&view_idxs, num_entries);
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
