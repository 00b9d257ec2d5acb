#pragma once

#include <cstddef>
#include <cstdio>
#include <list>
#include <memory>
#include <vector>

#include "lsmvs/stereo/quasi_dense_points_internal.h"

namespace lsmvs::quasi_dense {

// The interest points of all views, of which no more than the budget are in memory: what was not
// used for longest lies in a temporary file without a name (in the folder that TMPDIR says, else
// /tmp), which goes with the store. For one thread.
class GridStore {
 public:
  GridStore(size_t num_views, size_t budget_bytes);
  ~GridStore();
  GridStore(const GridStore&) = delete;
  GridStore& operator=(const GridStore&) = delete;

  // The grid last put, an empty one if none was. Stays valid whatever is done with the store.
  // Error(kFileSystem) if the file cannot be read.
  std::shared_ptr<const PointGrid> Get(int view_idx);
  // Error(kFileSystem) if there is no room for the file.
  void Put(int view_idx, PointGrid grid);

  // Of the grids in memory; above the budget only by what was used last.
  size_t held_bytes() const { return held_bytes_; }

 private:
  struct Entry {
    std::shared_ptr<const PointGrid> grid;  // null: not in memory
    std::list<int>::iterator place;         // in order_, while it is in memory
    bool in_file = false;                   // the file holds this grid
    size_t offset = 0, capacity = 0;        // its bytes in the file
    float spacing = 1;
    int width = 0, height = 0;
  };

  void Hold(int view_idx, std::shared_ptr<const PointGrid> grid);
  void Drop(int view_idx);
  void Write(Entry* entry);
  std::shared_ptr<const PointGrid> Read(const Entry& entry);

  size_t budget_bytes_, held_bytes_ = 0;
  std::vector<Entry> entries_;  // by view
  std::list<int> order_;        // views in memory, most recently used first
  std::FILE* file_ = nullptr;   // from the first grid that has no room on
  size_t file_end_ = 0;
};

}  // namespace lsmvs::quasi_dense
