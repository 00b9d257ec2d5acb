#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

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

// What must hold for points and what is dropped of them, one point after the other.
class PointCheck {
 public:
  // Of the images of the model, which must stay as they are.
  PointCheck(const std::filesystem::path& path, const SparseModel& model);
  // Throws InputError; drops the elements of its track that name nothing.
  void Check(SparseModel::Point3d* point);
  void DropDangling(SparseModel::Point3d* point);
  // Throws InputError if two points had the same number.
  void Finish();
  // Empty if nothing was dropped.
  std::string Warning() const;

 private:
  const std::string path_;
  std::unordered_map<uint32_t, uint64_t> num_features_;  // by image
  std::vector<uint64_t> ids_;
  size_t num_elements_ = 0, num_dropped_ = 0;
};
// Throws InputError if an identifier is there twice; orders them unless they are ascending.
void CheckPointIds(const std::string& path, std::vector<uint64_t>* ids);
void CheckPointIsFinite(const std::string& path, const SparseModel::Point3d& point);

// Takes points one after the other; `expect`, unless empty, hears before how many will come, where
// the file says so.
struct PointSink {
  std::function<void(SparseModel::Point3d)> take;
  std::function<void(uint64_t)> expect = {};
};

void ReadCamerasBinary(const std::filesystem::path& path, SparseModel* model);
void ReadImagesBinary(const std::filesystem::path& path, bool keep_points2d, SparseModel* model);
void ReadPoints3dBinary(const std::filesystem::path& path, const PointSink& sink);
void ReadRigsBinary(const std::filesystem::path& path, SparseModel* model);
void ReadFramesBinary(const std::filesystem::path& path, SparseModel* model);

void ReadCamerasText(const std::filesystem::path& path, SparseModel* model);
void ReadImagesText(const std::filesystem::path& path, bool keep_points2d, SparseModel* model);
void ReadPoints3dText(const std::filesystem::path& path, const PointSink& sink);
void ReadRigsText(const std::filesystem::path& path, SparseModel* model);
void ReadFramesText(const std::filesystem::path& path, SparseModel* model);

void WriteModelBinary(const FileNames& names, const SparseModel& model);
void WriteModelText(const FileNames& names, const SparseModel& model);

}  // namespace lsmvs::internal
