#pragma once

#include <filesystem>

#include "lsmvs/colmap_adapter/sparse_model.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"

// One function a file of a model. Readers append to the (empty) list of the model that the file is
// about; they check the syntax, CheckSparseModel checks the rest.
namespace lsmvs::internal {

inline constexpr const char* kSparseRemedy = "export the sparse model again";
inline constexpr size_t kMaxNameLength = 4096;
inline constexpr uint64_t kMaxImageSide = 1000000;

struct FileNames {
  std::filesystem::path cameras, images, points3d, rigs, frames;
  FileNames(const std::filesystem::path& folder, SparseFormat format);
};

// Drops what ReadSparseModel says that it drops, and says so in model->warnings.
void DropDanglingTracks(const std::filesystem::path& path, SparseModel* model);

void ReadCamerasBinary(const std::filesystem::path& path, SparseModel* model);
void ReadImagesBinary(const std::filesystem::path& path, bool keep_points2d, SparseModel* model);
void ReadPoints3dBinary(const std::filesystem::path& path, SparseModel* model);
void ReadRigsBinary(const std::filesystem::path& path, SparseModel* model);
void ReadFramesBinary(const std::filesystem::path& path, SparseModel* model);

void ReadCamerasText(const std::filesystem::path& path, SparseModel* model);
void ReadImagesText(const std::filesystem::path& path, bool keep_points2d, SparseModel* model);
void ReadPoints3dText(const std::filesystem::path& path, SparseModel* model);
void ReadRigsText(const std::filesystem::path& path, SparseModel* model);
void ReadFramesText(const std::filesystem::path& path, SparseModel* model);

void WriteModelBinary(const FileNames& names, const SparseModel& model);
void WriteModelText(const FileNames& names, const SparseModel& model);

}  // namespace lsmvs::internal
