#include "lsmvs/colmap_adapter/dense_workspace.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

std::string ToString(DepthMapKind type) {
  return type == DepthMapKind::kPhotometric ? "photometric" : "geometric";
}

namespace {

std::string MapFileName(const std::string& image_name, DepthMapKind type) {
  return fmt::format("{}.{}.bin", image_name, ToString(type));
}

// Whether a folder's content allows dense work: images and a model.
bool HasImagesAndModel(const fs::path& folder) {
  const fs::path sparse = DenseWorkspace{folder}.SparseFolder();
  return fs::is_directory(folder / "images") && sparse != folder && IsSparseModelFolder(sparse);
}

// Sub-folders whose names are numbers, as COLMAP counts models.
std::map<int, fs::path> NumberedFolders(const fs::path& folder) {
  std::map<int, fs::path> numbered;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    int number = 0;
    const auto [last, parse_error] =
        std::from_chars(name.data(), name.data() + name.size(), number);
    const bool is_number =
        parse_error == std::errc() && last == name.data() + name.size() && number >= 0;
    if (is_number && std::to_string(number) == name && entry.is_directory()) {
      numbered[number] = entry.path();
    }
  }
  return numbered;
}

std::map<int, fs::path> SparseModels(const fs::path& project) {
  const fs::path sparse = project / "sparse";
  if (IsSparseModelFolder(sparse)) return {{0, sparse}};
  std::map<int, fs::path> models = NumberedFolders(sparse);
  std::erase_if(models, [](const auto& model) { return !IsSparseModelFolder(model.second); });
  return models;
}

bool IsMissingOrEmpty(const fs::path& folder) {
  return !fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder));
}

// Whether dense/N is there; throws if something else is in its way.
bool CheckExistingWorkspace(const fs::path& folder) {
  if (IsMissingOrEmpty(folder)) return false;
  if (HasImagesAndModel(folder)) return true;
  throw InputError(folder.string(),
                   "is not a complete dense workspace (no images/ or sparse model)",
                   "remove it to have it made again, or move it away");
}

void CheckPhotoFolder(const fs::path& image_folder) {
  if (!fs::is_directory(image_folder)) {
    throw InputError(image_folder.string(), "the folder of the photos is missing",
                     "name the photos' folder with --image_path");
  }
  if (fs::is_empty(image_folder)) {
    throw InputError(image_folder.string(), "the folder of the photos is empty",
                     "put the photos there or name their folder with --image_path");
  }
}

std::vector<WorkspaceEntry> EntriesOfProject(const fs::path& project,
                                             const fs::path& image_folder) {
  std::map<int, WorkspaceEntry> entries;
  for (const auto& [number, folder] : NumberedFolders(project / "dense")) {
    if (CheckExistingWorkspace(folder)) entries[number] = {DenseWorkspace{folder}, true, {}, {}};
  }
  const fs::path photos = image_folder.empty() ? project / "images" : image_folder;
  for (const auto& [number, sparse_folder] : SparseModels(project)) {
    WorkspaceEntry& entry = entries[number];
    entry.workspace.folder = project / "dense" / std::to_string(number);
    entry.sparse_folder = sparse_folder;
    entry.image_folder = photos;
    if (!entry.exists) {
      CheckExistingWorkspace(entry.workspace.folder);
      CheckPhotoFolder(photos);
    }
  }
  std::vector<WorkspaceEntry> list;
  for (auto& [number, entry] : entries) list.push_back(std::move(entry));
  return list;
}

std::vector<WorkspaceEntry> EntriesOfFolderOfWorkspaces(const fs::path& path) {
  std::vector<WorkspaceEntry> entries;
  for (const auto& [number, folder] : NumberedFolders(path)) {
    if (HasImagesAndModel(folder)) entries.push_back({DenseWorkspace{folder}, true, {}, {}});
  }
  return entries;
}

std::vector<WorkspaceEntry> Existing(const fs::path& folder) {
  return {{DenseWorkspace{folder}, true, {}, {}}};
}

[[noreturn]] void FailNothingFound(const fs::path& path) {
  if (IsSparseModelFolder(path)) {
    throw InputError(path.string(), "is a sparse model, not a workspace",
                     "name the folder above that holds images/ and sparse/");
  }
  if (fs::is_directory(path / "sparse")) {
    const fs::path first = path / "sparse" / "0";
    const fs::path folder = fs::is_directory(first) ? first : path / "sparse";
    throw InputError(folder.string(), DescribeMissingModel(folder), "run `colmap mapper` first");
  }
  throw InputError(
      path.string(),
      "is neither a dense workspace (images/, sparse/, stereo/) nor a project (images/, "
      "sparse/0) nor a folder with dense/0",
      "name the folder that `colmap mapper` or `colmap image_undistorter` wrote to");
}

}  // namespace

fs::path DenseWorkspace::SparseFolder() const {
  const fs::path sparse = folder / "sparse";
  if (IsSparseModelFolder(sparse)) return sparse;
  if (IsSparseModelFolder(sparse / "0")) return sparse / "0";
  return !fs::exists(sparse) && IsSparseModelFolder(folder) ? folder : sparse;
}

fs::path DenseWorkspace::ModelFile(const std::string& name) const {
  const fs::path model = SparseFolder();
  const bool binary = fs::exists(model / "cameras.bin");
  return model / (name + (binary ? ".bin" : ".txt"));
}

std::vector<fs::path> DenseWorkspace::ModelFiles() const {
  std::vector<fs::path> files;
  for (const char* name : {"cameras", "images", "points3D", "rigs", "frames"}) {
    if (const fs::path path = ModelFile(name); fs::exists(path)) files.push_back(path);
  }
  return files;
}

fs::path DenseWorkspace::DepthMapPath(const std::string& image_name, DepthMapKind type) const {
  return StereoFolder() / "depth_maps" / MapFileName(image_name, type);
}

fs::path DenseWorkspace::NormalMapPath(const std::string& image_name, DepthMapKind type) const {
  return StereoFolder() / "normal_maps" / MapFileName(image_name, type);
}

fs::path DenseWorkspace::VisibilityPath(const fs::path& fused_path) {
  fs::path path = fused_path;
  path += ".vis";
  return path;
}

bool IsDenseWorkspace(const fs::path& folder) {
  const DenseWorkspace workspace{folder};
  const fs::path sparse = workspace.SparseFolder();
  if (sparse == folder || !IsSparseModelFolder(sparse)) return false;
  if (fs::is_directory(workspace.StereoFolder())) return true;
  return IsSparseModelFolder(folder / "sparse") &&
         (fs::exists(workspace.FusedPath()) || fs::is_directory(workspace.RunFolder()));
}

std::vector<WorkspaceEntry> FindDenseWorkspaces(const fs::path& path,
                                                const fs::path& image_folder) {
  if (!fs::is_directory(path)) {
    throw InputError(path.string(), fs::exists(path) ? "is not a folder" : "does not exist",
                     "name the folder of a COLMAP workspace");
  }
  if (IsDenseWorkspace(path)) return Existing(path);
  // `image_undistorter --output_path project/dense`, as COLMAP's tutorial has it.
  if (IsDenseWorkspace(path / "dense")) return Existing(path / "dense");
  std::vector<WorkspaceEntry> entries = EntriesOfProject(path, image_folder);
  if (entries.empty()) entries = EntriesOfFolderOfWorkspaces(path);
  if (entries.empty()) FailNothingFound(path);
  return entries;
}

}  // namespace lsmvs
