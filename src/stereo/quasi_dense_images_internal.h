#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <utility>

#include "lsmvs/image/image_store.h"
#include "lsmvs/stereo/quasi_dense_window_internal.h"

namespace lsmvs::quasi_dense {

// Packed images of the store's views, the most recently used ones within a budget. For one thread.
class CellImages {
 public:
  CellImages(const ImageStore& images, size_t budget_bytes)
      : images_(images), budget_bytes_(budget_bytes) {}

  std::shared_ptr<const CellImage> Get(int view_idx, int level);

 private:
  using Key = std::pair<int, int>;
  struct Entry {
    std::shared_ptr<const CellImage> image;
    std::list<Key>::iterator place;
  };

  const ImageStore& images_;
  size_t budget_bytes_, held_bytes_ = 0;
  std::map<Key, Entry> entries_;
  std::list<Key> order_;  // most recently used first
};

}  // namespace lsmvs::quasi_dense
