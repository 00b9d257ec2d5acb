#include "lsmvs/stereo/quasi_dense_grids_internal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include "lsmvs/util/error.h"
#include "lsmvs/util/unnamed_file.h"

namespace lsmvs::quasi_dense {

namespace {

size_t Bytes(const PointGrid& grid) { return grid.cells.size() * sizeof(InterestPoint); }

[[noreturn]] void ThrowFileError(const std::string& action) {
  throw Error(ExitCode::kFileSystem,
              fmt::format("{}: cannot {}: {}; let TMPDIR name a folder on a larger disk, or give "
                          "more memory, so that fewer interest points are put aside there",
                          FolderForTemporaryFiles().string(), action, std::strerror(errno)));
}

std::FILE* OpenTemporaryFile() {
  std::string name = (FolderForTemporaryFiles() / "lsmvs-points-XXXXXX").string();
  const int descriptor = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) ThrowFileError("make a temporary file");
  unlink(name.c_str());  // its place is given back however the process ends
  return fdopen(descriptor, "w+b");
}

}  // namespace

GridStore::GridStore(size_t num_views, size_t budget_bytes)
    : budget_bytes_(budget_bytes), entries_(num_views) {}

GridStore::~GridStore() {
  if (file_ != nullptr) std::fclose(file_);
}

std::shared_ptr<const PointGrid> GridStore::Get(int view_idx) {
  Entry& entry = entries_[static_cast<size_t>(view_idx)];
  if (entry.grid != nullptr) {
    order_.splice(order_.begin(), order_, entry.place);
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
  Entry& entry = entries_[static_cast<size_t>(view_idx)];
  held_bytes_ += Bytes(*grid);
  entry.grid = std::move(grid);
  order_.push_front(view_idx);
  entry.place = order_.begin();
  while (held_bytes_ > budget_bytes_ && order_.size() > 1) {
    Entry& oldest = entries_[static_cast<size_t>(order_.back())];
    if (!oldest.in_file) Write(&oldest);
    Drop(order_.back());
  }
}

void GridStore::Drop(int view_idx) {
  Entry& entry = entries_[static_cast<size_t>(view_idx)];
  held_bytes_ -= Bytes(*entry.grid);
  entry.grid.reset();
  order_.erase(entry.place);
}

void GridStore::Write(Entry* entry) {
  if (file_ == nullptr) file_ = OpenTemporaryFile();
  const size_t size = Bytes(*entry->grid);
  if (size > entry->capacity) {
    entry->offset = file_end_;
    entry->capacity = size;
    file_end_ += size;
  }
  const bool done = fseeko(file_, static_cast<off_t>(entry->offset), SEEK_SET) == 0 &&
                    std::fwrite(entry->grid->cells.pixels.data(), 1, size, file_) == size &&
                    std::fflush(file_) == 0;
  if (!done) ThrowFileError("write interest points to a temporary file");
  entry->in_file = true;
}

std::shared_ptr<const PointGrid> GridStore::Read(const Entry& entry) {
  auto grid = std::make_shared<PointGrid>();
  grid->spacing = entry.spacing;
  grid->cells = Raster<InterestPoint>(entry.width, entry.height);
  const size_t size = Bytes(*grid);
  const bool done = fseeko(file_, static_cast<off_t>(entry.offset), SEEK_SET) == 0 &&
                    std::fread(grid->cells.pixels.data(), 1, size, file_) == size;
  if (!done) ThrowFileError("read interest points back from a temporary file");
  return grid;
}

}  // namespace lsmvs::quasi_dense
