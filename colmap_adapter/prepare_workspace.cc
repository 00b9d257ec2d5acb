#include "lsmvs/colmap_adapter/prepare_workspace.h"

#include <fmt/format.h>

#include <cerrno>

#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/image/image_store.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

// image_undistorter goes on without an image that it cannot read, so what it gets and what it makes
// is checked.
void CheckPhotos(const SparseModel& model, const fs::path& image_folder) {
  for (const SparseModel::Image& image : model.images) {
    if (fs::is_regular_file(image_folder / image.name)) continue;
    throw InputError(
        (image_folder / image.name).string(), "image file is missing",
        "put it back, name the photos' folder with --image_path, or remove it from the model");
  }
}

void CheckUndistorted(const DenseWorkspace& workspace, const SparseModel& model,
                      const fs::path& image_folder) {
  const SparseModel undistorted =
      ReadSparseModel(workspace.SparseFolder(), {.keep_points2d = false});
  for (const SparseModel::Image& image : undistorted.images) {
    if (!fs::exists(workspace.ImagePath(image.name))) {
      throw InputError((image_folder / image.name).string(), "could not be undistorted",
                       "check that it can be opened as an image");
    }
    ReadImageSize(workspace.ImagePath(image.name).string());
  }
  if (undistorted.images.size() != model.images.size()) {
    throw InputError(image_folder.string(),
                     fmt::format("only {} of {} photos were undistorted", undistorted.images.size(),
                                 model.images.size()),
                     "check that all can be opened as images");
  }
}

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
  if (error) throw FileSystemError(to.string(), "put the workspace in place", error.value());
}

// Removes a folder when the work in it does not get to its end.
class TemporaryWorkspace {
 public:
  explicit TemporaryWorkspace(const fs::path& final_folder)
      : final_folder_(final_folder),
        folder_(final_folder.parent_path() /
                fmt::format(".{}.lsmvs-tmp", final_folder.filename().string())) {
    RemoveFolder(folder_);
    MakeFolder(folder_);
  }
  ~TemporaryWorkspace() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  TemporaryWorkspace(const TemporaryWorkspace&) = delete;
  TemporaryWorkspace& operator=(const TemporaryWorkspace&) = delete;

  const fs::path& folder() const { return folder_; }
  void Keep() { RenameFolder(folder_, final_folder_); }

 private:
  const fs::path final_folder_, folder_;
};

// COLMAP's text reader takes a name to end at its first blank, and fails on references to nothing.
bool NeedsCopyForColmap(const fs::path& sparse_folder, const SparseModel& model) {
  return !model.warnings.empty() || !fs::exists(sparse_folder / "cameras.bin");
}

std::vector<std::string> UndistorterArguments(const WorkspaceEntry& entry,
                                              const PrepareWorkspaceOptions& options,
                                              const fs::path& output) {
  std::vector<std::string> arguments = {"image_undistorter",
                                        "--image_path",
                                        entry.image_folder.string(),
                                        "--input_path",
                                        entry.sparse_folder.string(),
                                        "--output_path",
                                        output.string(),
                                        "--output_type",
                                        "COLMAP"};
  if (options.max_image_size) {
    arguments.insert(arguments.end(),
                     {"--max_image_size", std::to_string(*options.max_image_size)});
  }
  return arguments;
}

}  // namespace

DenseWorkspace PrepareDenseWorkspace(const WorkspaceEntry& entry, const ColmapRunner& runner,
                                     const PrepareWorkspaceOptions& options,
                                     const RunContext& context) {
  if (entry.exists) return entry.workspace;
  const SparseModel model = ReadSparseModel(entry.sparse_folder, {.keep_points2d = false});
  if (model.images.empty()) {
    throw InputError(entry.sparse_folder.string(), "has no registered image",
                     "check the output of `colmap mapper`: it could not place any photo");
  }
  LogWarnings(model);
  CheckPhotos(model, entry.image_folder);
  const fs::path& folder = entry.workspace.folder;
  TemporaryWorkspace temporary(folder);
  std::optional<TemporaryWorkspace> model_copy;
  WorkspaceEntry source = entry;
  if (NeedsCopyForColmap(entry.sparse_folder, model)) {
    model_copy.emplace(folder.string() + "-sparse");
    source.sparse_folder = model_copy->folder();
    WriteSparseModel(source.sparse_folder, ReadSparseModel(entry.sparse_folder));
  }
  const fs::path log_path =
      folder.parent_path() / fmt::format("image_undistorter-{}.log", folder.filename().string());
  runner.Run(UndistorterArguments(source, options, temporary.folder()), log_path, context);
  CheckUndistorted(DenseWorkspace{temporary.folder()}, model, entry.image_folder);
  temporary.Keep();
  return entry.workspace;
}

std::vector<DenseWorkspace> PrepareDenseWorkspaces(const fs::path& path, const ColmapRunner& runner,
                                                   const PrepareWorkspaceOptions& options,
                                                   const RunContext& context) {
  std::vector<DenseWorkspace> workspaces;
  const std::vector<WorkspaceEntry> entries = FindDenseWorkspaces(path, options.image_folder);
  for (size_t i = 0; i < entries.size(); ++i) {
    workspaces.push_back(PrepareDenseWorkspace(entries[i], runner, options, context));
    context.Report(static_cast<double>(i + 1) / static_cast<double>(entries.size()));
  }
  return workspaces;
}

}  // namespace lsmvs
