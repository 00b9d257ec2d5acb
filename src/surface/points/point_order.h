#pragma once

#include <cstdint>
#include <span>

#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// The view that sees a point finest: the least depth per focal length.
struct FinestView {
  static constexpr uint32_t kNone = 0xFFFFFFFFu;
  uint32_t view_idx = kNone;  // kNone: the point is before none of its views, or not finite
  double depth = 0;           // world
  double pixel_size = 0;      // world
};

FinestView FindFinestView(const Scene& scene, const VisibilityCloud& cloud, size_t point);

// Orders the points of a cloud by what they are, not by where the cloud holds them. Points that no
// order tells apart are equal in all they have.
class PointOrder {
 public:
  // Keeps pointers to both.
  PointOrder(const Scene& scene, const VisibilityCloud& cloud) : scene_(scene), cloud_(cloud) {}

  // By position, normal, colour and views.
  bool Less(uint32_t a, uint32_t b) const;

  // By finest view, and in its photo tile by tile, row by row within a tile; then by Less. Points
  // that follow each other lie close together, and the order does not depend on the world's frame
  // up to rounding. Each point must have a finest view. O(n log n); 16 bytes a point.
  void SortAlongViews(const RunContext& context, std::span<uint32_t> points) const;

 private:
  uint64_t KeyAlongViews(uint32_t point) const;

  const Scene& scene_;
  const VisibilityCloud& cloud_;
};

// Of the position alone; equal positions have equal hashes.
uint64_t HashOfPosition(const Eigen::Vector3f& x);

}  // namespace lsmvs
