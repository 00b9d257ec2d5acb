#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lsmvs/stereo/quasi_dense/points.h"
#include "lsmvs/util/lru_cache.h"
#include "lsmvs/util/unnamed_file.h"

namespace lsmvs::quasi_dense {

// LRU store of all views' interest points; grids beyond the budget go to an unlinked temporary file
// in $TMPDIR or /tmp, which ends with the store. For one thread.
class GridStore {
 public:
  GridStore(size_t num_views, size_t budget_bytes);
  GridStore(const GridStore&) = delete;
  GridStore& operator=(const GridStore&) = delete;

  // The grid last put, an empty one if none was. Stays valid whatever is done with the store.
  // Error(kFileSystem) if the file cannot be read.
  std::shared_ptr<const PointGrid> Get(int view_idx);
  // Error(kFileSystem) if there is no room for the file.
  void Put(int view_idx, PointGrid grid);

  // Of the grids in memory; above the budget only by what was used last.
  size_t held_bytes() const { return in_memory_.held_bytes(); }

 private:
  struct Entry {
    std::shared_ptr<const PointGrid> grid;  // null: not in memory
    bool in_file = false;                   // the file holds this grid
    size_t offset = 0, capacity = 0;        // its bytes in the file
    float spacing = 1;
    int width = 0, height = 0;
  };

  void Hold(int view_idx, std::shared_ptr<const PointGrid> grid);
  void Drop(int view_idx);
  void Write(Entry* entry);
  std::shared_ptr<const PointGrid> Read(const Entry& entry);

  size_t budget_bytes_;
  std::vector<Entry> entries_;         // by view
  LruOrder<int> in_memory_;            // views
  std::unique_ptr<UnnamedFile> file_;  // from the first grid that has no room on
  size_t file_end_ = 0;
};

}  // namespace lsmvs::quasi_dense
