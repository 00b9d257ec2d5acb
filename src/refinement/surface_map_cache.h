#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/refinement/surface_warp.h"

namespace lsmvs {

// Depth and face maps of the views, made when they are asked for and kept while they fit the budget
// (the least recently used are dropped). Refers to the vertices and faces it was made with, which
// must neither move nor change meanwhile. Thread-safe; two threads that ask for the same view at
// once make it once.
class SurfaceMapCache {
 public:
  SurfaceMapCache(const std::vector<LevelView>* views, std::span<const Eigen::Vector3d> vertices,
                  std::span<const Eigen::Vector3i> faces, size_t budget_bytes);

  std::shared_ptr<const SurfaceMaps> Get(int view_idx);

 private:
  struct Entry {
    std::mutex drawing;
    std::shared_ptr<const SurfaceMaps> maps;
    std::list<int>::iterator place;
    bool listed = false;
  };

  void Account(int view_idx, std::shared_ptr<const SurfaceMaps> maps);
  std::shared_ptr<const SurfaceMaps> Held(int view_idx);

  const std::vector<LevelView>* views_;
  std::span<const Eigen::Vector3d> vertices_;
  std::span<const Eigen::Vector3i> faces_;
  size_t budget_bytes_;
  std::mutex mutex_;  // of what follows, but for Entry::drawing
  std::vector<std::unique_ptr<Entry>> entries_;
  std::list<int> order_;  // most recently used first
  size_t held_bytes_ = 0;
};

}  // namespace lsmvs
