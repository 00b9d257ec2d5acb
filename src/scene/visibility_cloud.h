#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// Points with the views that see each of them: what every stereo variant makes and the surface
// stage takes (fused.ply + fused.ply.vis on disk). Structure of arrays; #P is size().
struct VisibilityCloud {
  std::vector<Eigen::Vector3f> positions;  // in the world (minus Scene::world_offset)
  std::vector<Eigen::Vector3f> normals;    // unit length, towards the cameras; zero if unknown
  std::vector<Color> colors;
  // Views of point p: view_idxs[view_begin[p] .. view_begin[p+1]), ascending, without duplicates.
  std::vector<uint64_t> view_begin = {0};  // #P + 1
  std::vector<uint32_t> view_idxs;         // positions in Scene::views

  size_t size() const { return positions.size(); }
  std::span<const uint32_t> ViewsOf(size_t point) const {
    return {view_idxs.data() + view_begin[point], view_idxs.data() + view_begin[point + 1]};
  }
  // `views` need not be sorted; duplicates are dropped.
  void Add(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, const Color& color,
           std::span<const uint32_t> views);
  void Append(const VisibilityCloud& other);
  // Drops the points for which `keep` is false; the others keep their order. In place: beside the
  // cloud at most one of its arrays, of the points that are kept, is held.
  void KeepIf(const std::function<bool(size_t point)>& keep);
  void Reserve(size_t num_points, size_t num_view_entries);
  // Throws std::logic_error if arrays do not fit each other or a view is not below `num_views`.
  void CheckConsistent(size_t num_views) const;
};

// Takes the points of a cloud that is too large to be held, part by part, in order.
using CloudSink = std::function<void(const VisibilityCloud& part)>;

}  // namespace lsmvs
