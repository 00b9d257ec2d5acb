#include "lsmvs/stereo/quasi_dense/grid_store.h"

#include <fmt/format.h>

#include <utility>

#include "lsmvs/util/error.h"

namespace lsmvs::quasi_dense {

namespace {

size_t Bytes(const PointGrid& grid) { return grid.cells.size() * sizeof(InterestPoint); }

// Runs what uses the temporary file; a failure says how to avoid the file.
template <class Use>
void WithAdvice(const Use& use) {
  try {
    use();
  } catch (const Error& error) {
    throw Error(
        error.code(),
        fmt::format("{}; let TMPDIR name a folder on a larger disk, or give more memory, so "
                    "that fewer interest points are put aside there",
                    error.what()));
  }
}

}  // namespace

GridStore::GridStore(size_t num_views, size_t budget_bytes)
    : budget_bytes_(budget_bytes), entries_(num_views) {}

std::shared_ptr<const PointGrid> GridStore::Get(int view_idx) {
  Entry& entry = entries_[static_cast<size_t>(view_idx)];
  if (entry.grid != nullptr) {
    in_memory_.Use(view_idx);
    return entry.grid;
  }
  auto grid = entry.in_file ? Read(entry) : std::make_shared<const PointGrid>();
  if (entry.in_file) Hold(view_idx, grid);
  return grid;
}

void GridStore::Put(int view_idx, PointGrid grid) {
  Entry& entry = entries_[static_cast<size_t>(view_idx)];
  if (entry.grid != nullptr) Drop(view_idx);
  entry.in_file = false;
  entry.spacing = grid.spacing;
  entry.width = grid.cells.width;
  entry.height = grid.cells.height;
  Hold(view_idx, std::make_shared<const PointGrid>(std::move(grid)));
}

void GridStore::Hold(int view_idx, std::shared_ptr<const PointGrid> grid) {
  in_memory_.Use(view_idx);
  in_memory_.SetBytes(view_idx, Bytes(*grid));
  entries_[static_cast<size_t>(view_idx)].grid = std::move(grid);
  while (in_memory_.held_bytes() > budget_bytes_) {
    const auto oldest = in_memory_.LeastRecent([&](int other) { return other != view_idx; });
    if (!oldest) return;
    Entry& entry = entries_[static_cast<size_t>(*oldest)];
    if (!entry.in_file) Write(&entry);
    Drop(*oldest);
  }
}

void GridStore::Drop(int view_idx) {
  entries_[static_cast<size_t>(view_idx)].grid.reset();
  in_memory_.Remove(view_idx);
}

void GridStore::Write(Entry* entry) {
  WithAdvice([&] {
    if (!file_) file_ = std::make_unique<UnnamedFile>(FolderForTemporaryFiles());
  });
  const size_t size = Bytes(*entry->grid);
  if (size > entry->capacity) {
    entry->offset = file_end_;
    entry->capacity = size;
    file_end_ += size;
  }
  WithAdvice([&] { file_->Write(entry->offset, entry->grid->cells.pixels.data(), size); });
  entry->in_file = true;
}

std::shared_ptr<const PointGrid> GridStore::Read(const Entry& entry) {
  auto grid = std::make_shared<PointGrid>();
  grid->spacing = entry.spacing;
  grid->cells = Raster<InterestPoint>(entry.width, entry.height);
  WithAdvice([&] { file_->Read(entry.offset, grid->cells.pixels.data(), Bytes(*grid)); });
  return grid;
}

}  // namespace lsmvs::quasi_dense
