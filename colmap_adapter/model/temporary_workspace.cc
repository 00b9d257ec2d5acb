#include <fmt/format.h>

#include "lsmvs/colmap_adapter/model/temporary_workspace.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileSystemError(folder.string(), "create the folder", error.value());
}

void RemoveFolder(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (error) throw FileSystemError(folder.string(), "remove the folder", error.value());
}

void RenameFolder(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) throw FileSystemError(to.string(), "put the folder in place", error.value());
}

}  // namespace

TemporaryWorkspace::TemporaryWorkspace(const fs::path& final_folder)
    : final_folder_(final_folder),
      folder_(final_folder.parent_path() /
              fmt::format(".{}.lsmvs-tmp", final_folder.filename().string())) {
  RemoveFolder(folder_);
  MakeFolder(folder_);
}

TemporaryWorkspace::~TemporaryWorkspace() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void TemporaryWorkspace::Keep() {
  RemoveFolder(final_folder_);
  RenameFolder(folder_, final_folder_);
}

}  // namespace lsmvs
