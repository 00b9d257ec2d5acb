#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/refinement/photo/surface_warp.h"
#include "lsmvs/util/lru_cache.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct DrawnMaps {
  std::shared_ptr<const Raster<float>> depth;
  std::shared_ptr<const Raster<int32_t>> face;
};

// Depth and face maps of the views, made when they are asked for. Depth maps are kept until their
// last expected use has ended, as far as they fit the budget (the least recently used are dropped
// and drawn again); face maps, which only the view itself needs, are kept until it took them.
// Refers to the vertices and faces it was made with, which must neither move nor change meanwhile.
// Thread-safe; two threads that ask for the same view at once make it once.
class SurfaceMapCache {
 public:
  // `keeps_faces` = false: nobody will ask for face maps.
  SurfaceMapCache(const std::vector<PosedCamera>* views, std::span<const Eigen::Vector3d> vertices,
                  std::span<const Eigen::Vector3i> faces, size_t budget_bytes, bool keeps_faces,
                  const RunContext& context);

  // Announces a use of a view's maps; before the first EndUse().
  void ExpectUse(int view_idx);
  void EndUse(int view_idx);

  // Both maps; the face map is handed over.
  DrawnMaps Draw(int view_idx);
  std::shared_ptr<const Raster<float>> Depth(int view_idx);

 private:
  struct Entry {
    std::mutex drawing;
    DrawnMaps maps;
    int num_uses = 0;
    bool needs_face = true;
  };

  // Of the entry; both null if it does not hold the maps that are asked for.
  DrawnMaps Take(int view_idx, bool with_face);
  DrawnMaps DrawAndKeep(int view_idx, bool with_face);
  void Drop(int view_idx);
  void DropFace(int view_idx);

  const std::vector<PosedCamera>* views_;
  std::span<const Eigen::Vector3d> vertices_;
  std::span<const Eigen::Vector3i> faces_;
  FaceBlocks blocks_;
  size_t budget_bytes_;
  std::mutex mutex_;  // of what follows, but for Entry::drawing
  std::vector<std::unique_ptr<Entry>> entries_;
  LruOrder<int> kept_;  // views with maps
};

}  // namespace lsmvs
