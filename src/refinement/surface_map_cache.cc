#include "lsmvs/refinement/surface_map_cache.h"

namespace lsmvs {

namespace {

size_t Bytes(const SurfaceMaps& maps) {
  return maps.depth.size() * sizeof(float) + maps.face.size() * sizeof(int32_t);
}

}  // namespace

SurfaceMapCache::SurfaceMapCache(const std::vector<LevelView>* views,
                                 std::span<const Eigen::Vector3d> vertices,
                                 std::span<const Eigen::Vector3i> faces, size_t budget_bytes)
    : views_(views), vertices_(vertices), faces_(faces), budget_bytes_(budget_bytes) {
  for (size_t v = 0; v < views->size(); ++v) entries_.push_back(std::make_unique<Entry>());
}

std::shared_ptr<const SurfaceMaps> SurfaceMapCache::Get(int view_idx) {
  if (auto maps = Held(view_idx)) return maps;
  Entry& entry = *entries_[static_cast<size_t>(view_idx)];
  const std::lock_guard<std::mutex> drawing(entry.drawing);
  if (auto maps = Held(view_idx)) return maps;
  const LevelView& view = (*views_)[static_cast<size_t>(view_idx)];
  auto maps = std::make_shared<SurfaceMaps>();
  RasterizeMesh(view.camera, view.cam_from_world, vertices_, faces_, {.cull_back_faces = false},
                maps.get());
  Account(view_idx, maps);
  return maps;
}

std::shared_ptr<const SurfaceMaps> SurfaceMapCache::Held(int view_idx) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = *entries_[static_cast<size_t>(view_idx)];
  if (entry.listed) order_.splice(order_.begin(), order_, entry.place);
  return entry.maps;
}

void SurfaceMapCache::Account(int view_idx, std::shared_ptr<const SurfaceMaps> maps) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = *entries_[static_cast<size_t>(view_idx)];
  held_bytes_ += Bytes(*maps);
  entry.maps = std::move(maps);
  order_.push_front(view_idx);
  entry.place = order_.begin();
  entry.listed = true;
  while (held_bytes_ > budget_bytes_ && order_.back() != view_idx) {
    Entry& oldest = *entries_[static_cast<size_t>(order_.back())];
    held_bytes_ -= Bytes(*oldest.maps);
    oldest.maps.reset();
    oldest.listed = false;
    order_.pop_back();
  }
}

}  // namespace lsmvs
