#include "lsmvs/colmap_adapter/prepare_workspace.h"

#include <fmt/format.h>

#include <set>

#include "lsmvs/colmap_adapter/model/missing_images.h"
#include "lsmvs/colmap_adapter/model/temporary_workspace.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/image/image_store.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

// image_undistorter goes on without an image that it cannot read, so what it gets and what it makes
// is checked.
std::set<std::string> FindMissing(const SparseModel& model, const fs::path& image_folder,
                                  bool skip_missing) {
  std::set<std::string> missing;
  for (const SparseModel::Image& image : model.images) {
    if (!fs::is_regular_file(image_folder / image.name)) missing.insert(image.name);
  }
  if (missing.empty()) return missing;
  const MissingImages images(image_folder, {missing.begin(), missing.end()}, model.images.size());
  if (!skip_missing || !images.LeavesEnough()) images.Throw();
  images.Warn();
  return missing;
}

void CheckEnough(const SparseModel& model, const fs::path& sparse_folder) {
  if (model.images.empty()) {
    throw InputError(sparse_folder.string(), "has no registered image",
                     "check the output of `colmap mapper`: it could not place any photo");
  }
  if (model.images.size() == 1) {
    throw InputError(sparse_folder.string(), "has one photo, and depth takes two at least",
                     "remove this model, or take more photos of what it shows");
  }
}

void RemoveImages(const std::set<std::string>& names, SparseModel* model) {
  std::set<uint64_t> ids;
  for (const SparseModel::Image& image : model->images) {
    if (names.contains(image.name)) ids.insert(static_cast<uint64_t>(image.image_id));
  }
  std::erase_if(model->images, [&](const auto& image) { return names.contains(image.name); });
  for (SparseModel::Point3d& point : model->points3d) {
    std::erase_if(point.track, [&](const SparseModel::TrackElement& element) {
      return ids.contains(static_cast<uint64_t>(element.image_id));
    });
  }
  for (SparseModel::Frame& frame : model->frames) {
    std::erase_if(frame.data, [&](const SparseModel::Frame::Data& data) {
      return data.sensor.type == SparseModel::SensorType::kCamera && ids.contains(data.data_id);
    });
  }
  std::erase_if(model->frames, [](const auto& frame) { return frame.data.empty(); });
}

void CheckUndistorted(const DenseWorkspace& workspace, size_t num_photos,
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
  if (undistorted.images.size() != num_photos) {
    throw InputError(
        image_folder.string(),
        fmt::format("only {} of {} photos were undistorted", undistorted.images.size(), num_photos),
        "check that all can be opened as images");
  }
}

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
  LogWarnings(model);
  CheckEnough(model, entry.sparse_folder);
  const std::set<std::string> missing =
      FindMissing(model, entry.image_folder, options.skip_missing_images);
  const fs::path& folder = entry.workspace.folder;
  TemporaryWorkspace temporary(folder);
  std::optional<TemporaryWorkspace> model_copy;
  WorkspaceEntry source = entry;
  if (!missing.empty() || NeedsCopyForColmap(entry.sparse_folder, model)) {
    model_copy.emplace(folder.string() + "-sparse");
    source.sparse_folder = model_copy->folder();
    SparseModel copy = ReadSparseModel(entry.sparse_folder);
    RemoveImages(missing, &copy);
    WriteSparseModel(source.sparse_folder, copy);
  }
  const fs::path log_path =
      folder.parent_path() / fmt::format("image_undistorter-{}.log", folder.filename().string());
  runner.Run(UndistorterArguments(source, options, temporary.folder()), log_path, context);
  CheckUndistorted(DenseWorkspace{temporary.folder()}, model.images.size() - missing.size(),
                   entry.image_folder);
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
