#include "lsmvs/colmap_adapter/sparse_model_io.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <utility>

#include "lsmvs/colmap_adapter/model/camera_model.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace internal {

FileNames::FileNames(const std::filesystem::path& folder, SparseFormat format) {
  const std::string extension = format == SparseFormat::kBinary ? ".bin" : ".txt";
  cameras = folder / ("cameras" + extension);
  images = folder / ("images" + extension);
  points3d = folder / ("points3D" + extension);
  rigs = folder / ("rigs" + extension);
  frames = folder / ("frames" + extension);
}

}  // namespace internal

namespace {

using internal::FileNames;

bool HasModelFiles(const FileNames& names) {
  return std::filesystem::is_regular_file(names.cameras) &&
         std::filesystem::is_regular_file(names.images) &&
         std::filesystem::is_regular_file(names.points3d);
}

// Rigs and frames belong together: a model has both or neither.
bool HasFrameFiles(const FileNames& names) {
  const bool has_rigs = std::filesystem::is_regular_file(names.rigs);
  const bool has_frames = std::filesystem::is_regular_file(names.frames);
  if (has_rigs != has_frames) {
    throw InputError((has_rigs ? names.frames : names.rigs).string(),
                     "is missing beside " + (has_rigs ? names.rigs : names.frames).string(),
                     internal::kSparseRemedy);
  }
  return has_rigs;
}

void ReadPoints(const FileNames& names, SparseFormat format, const internal::PointSink& sink) {
  if (format == SparseFormat::kBinary) {
    internal::ReadPoints3dBinary(names.points3d, sink);
  } else {
    internal::ReadPoints3dText(names.points3d, sink);
  }
}

void ReadPoints(const FileNames& names, SparseFormat format, const ReadSparseModelOptions& options,
                SparseModel* model) {
  if (!options.keep_points3d) return;
  ReadPoints(
      names, format,
      {.take = [model](SparseModel::Point3d point) { model->points3d.push_back(std::move(point)); },
       .expect = [model](uint64_t count) { model->points3d.reserve(count); }});
}

SparseModel ReadBinary(const FileNames& names, const ReadSparseModelOptions& options) {
  SparseModel model;
  internal::ReadCamerasBinary(names.cameras, &model);
  internal::ReadImagesBinary(names.images, options.keep_points2d, &model);
  ReadPoints(names, SparseFormat::kBinary, options, &model);
  if (HasFrameFiles(names)) {
    internal::ReadRigsBinary(names.rigs, &model);
    internal::ReadFramesBinary(names.frames, &model);
  }
  return model;
}

SparseModel ReadText(const FileNames& names, const ReadSparseModelOptions& options) {
  SparseModel model;
  internal::ReadCamerasText(names.cameras, &model);
  internal::ReadImagesText(names.images, options.keep_points2d, &model);
  ReadPoints(names, SparseFormat::kText, options, &model);
  if (HasFrameFiles(names)) {
    internal::ReadRigsText(names.rigs, &model);
    internal::ReadFramesText(names.frames, &model);
  }
  return model;
}

// The format of the model in the folder: binary if both are there.
SparseFormat FormatOf(const std::filesystem::path& folder) {
  for (const SparseFormat format : {SparseFormat::kBinary, SparseFormat::kText}) {
    if (HasModelFiles(FileNames(folder, format))) return format;
  }
  throw InputError(folder.string(), DescribeMissingModel(folder),
                   "run `colmap mapper` or name the folder of its output");
}

}  // namespace

bool IsSparseModelFolder(const std::filesystem::path& folder) {
  return HasModelFiles({folder, SparseFormat::kBinary}) ||
         HasModelFiles({folder, SparseFormat::kText});
}

std::string DescribeMissingModel(const std::filesystem::path& folder) {
  for (const auto& [format, extension] :
       {std::pair(SparseFormat::kBinary, ".bin"), std::pair(SparseFormat::kText, ".txt")}) {
    const FileNames names(folder, format);
    std::string missing;
    int num_missing = 0;
    for (const auto& path : {names.cameras, names.images, names.points3d}) {
      if (std::filesystem::is_regular_file(path)) continue;
      missing += (num_missing++ > 0 ? " and " : "") + path.filename().string();
    }
    if (num_missing < 3) {
      return fmt::format("holds no whole sparse model: {} {} missing", missing,
                         num_missing == 1 ? "is" : "are");
    }
  }
  return "holds no sparse model (cameras, images and points3D, .bin or .txt)";
}

SparseModel ReadSparseModel(const std::filesystem::path& folder,
                            const ReadSparseModelOptions& options) {
  const SparseFormat format = FormatOf(folder);
  const FileNames names(folder, format);
  SparseModel model =
      format == SparseFormat::kBinary ? ReadBinary(names, options) : ReadText(names, options);
  internal::DropDanglingTracks(folder, &model);
  CheckSparseModel(model, folder);
  return model;
}

void ReadSparsePoints(const std::filesystem::path& folder, SparseModel* model,
                      const std::function<void(uint64_t)>& expect,
                      const std::function<void(SparseModel::Point3d)>& take) {
  const SparseFormat format = FormatOf(folder);
  internal::PointCheck check(folder, *model);
  const auto check_and_take = [&](SparseModel::Point3d point) {
    check.Check(&point);
    take(std::move(point));
  };
  ReadPoints(FileNames(folder, format), format, {.take = check_and_take, .expect = expect});
  check.Finish();
  if (!check.Warning().empty()) model->warnings.push_back(check.Warning());
}

void LogWarnings(const SparseModel& model) {
  for (const std::string& warning : model.warnings) LOG(WARNING) << warning;
}

void WriteSparseModel(const std::filesystem::path& folder, const SparseModel& model,
                      SparseFormat format) {
  for (const SparseModel::Camera& camera : model.cameras) {
    const CameraModel* camera_model = FindCameraModel(camera.model_id);
    LSMVS_CHECK(camera_model != nullptr);
    LSMVS_CHECK_EQ(camera.params.size(), camera_model->num_params);
  }
  const FileNames names(folder, format);
  if (format == SparseFormat::kBinary) {
    internal::WriteModelBinary(names, model);
  } else {
    internal::WriteModelText(names, model);
  }
}

}  // namespace lsmvs
