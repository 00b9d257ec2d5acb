#include "lsmvs/refinement/photo/surface_map_cache.h"

namespace lsmvs {

namespace {

template <class T>
size_t Bytes(const std::shared_ptr<const Raster<T>>& map) {
  return map ? map->size() * sizeof(T) : 0;
}

}  // namespace

SurfaceMapCache::SurfaceMapCache(const std::vector<PosedCamera>* views,
                                 std::span<const Eigen::Vector3d> vertices,
                                 std::span<const Eigen::Vector3i> faces, size_t budget_bytes,
                                 bool keeps_faces, const RunContext& context)
    : views_(views),
      vertices_(vertices),
      faces_(faces),
      blocks_(vertices, faces, context),
      budget_bytes_(budget_bytes) {
  for (size_t v = 0; v < views->size(); ++v) {
    entries_.push_back(std::make_unique<Entry>());
    entries_.back()->needs_face = keeps_faces;
  }
}

void SurfaceMapCache::ExpectUse(int view_idx) {
  ++entries_[static_cast<size_t>(view_idx)]->num_uses;
}

void SurfaceMapCache::EndUse(int view_idx) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (--entries_[static_cast<size_t>(view_idx)]->num_uses == 0) Drop(view_idx);
}

DrawnMaps SurfaceMapCache::Draw(int view_idx) {
  DrawnMaps maps = Take(view_idx, true);
  return maps.depth ? maps : DrawAndKeep(view_idx, true);
}

std::shared_ptr<const Raster<float>> SurfaceMapCache::Depth(int view_idx) {
  DrawnMaps maps = Take(view_idx, false);
  return maps.depth ? maps.depth : DrawAndKeep(view_idx, false).depth;
}

DrawnMaps SurfaceMapCache::Take(int view_idx, bool with_face) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = *entries_[static_cast<size_t>(view_idx)];
  if (kept_.Contains(view_idx)) kept_.Use(view_idx);
  if (with_face && !entry.maps.face) return {};
  DrawnMaps taken = entry.maps;
  if (with_face) DropFace(view_idx);
  return taken;
}

DrawnMaps SurfaceMapCache::DrawAndKeep(int view_idx, bool with_face) {
  Entry& entry = *entries_[static_cast<size_t>(view_idx)];
  const std::lock_guard<std::mutex> drawing(entry.drawing);
  if (DrawnMaps maps = Take(view_idx, with_face); maps.depth) return maps;
  const PosedCamera& view = (*views_)[static_cast<size_t>(view_idx)];
  SurfaceMaps drawn;
  RasterizeMesh(view.camera, view.cam_from_world, vertices_, faces_, {.blocks = &blocks_}, &drawn);
  DrawnMaps maps{std::make_shared<Raster<float>>(std::move(drawn.depth)),
                 std::make_shared<Raster<int32_t>>(std::move(drawn.face))};
  const std::lock_guard<std::mutex> lock(mutex_);
  Drop(view_idx);
  entry.maps = maps;
  if (with_face) entry.needs_face = false;
  if (!entry.needs_face) entry.maps.face.reset();
  kept_.Use(view_idx);
  kept_.SetBytes(view_idx, Bytes(entry.maps.depth) + Bytes(entry.maps.face));
  while (kept_.held_bytes() > budget_bytes_) {
    const auto oldest = kept_.LeastRecent([&](int other) { return other != view_idx; });
    if (!oldest) break;
    Drop(*oldest);
  }
  return maps;
}

void SurfaceMapCache::Drop(int view_idx) {
  entries_[static_cast<size_t>(view_idx)]->maps = {};
  kept_.Remove(view_idx);
}

void SurfaceMapCache::DropFace(int view_idx) {
  Entry& entry = *entries_[static_cast<size_t>(view_idx)];
  entry.maps.face.reset();
  entry.needs_face = false;
  kept_.SetBytes(view_idx, Bytes(entry.maps.depth));
}

}  // namespace lsmvs
