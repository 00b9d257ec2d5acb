#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "lsmvs/colmap_adapter/sparse_model.h"

namespace lsmvs {

enum class SparseFormat { kBinary, kText };

struct ReadSparseModelOptions {
  // The features of the images are most of a model's bytes and not needed to make a Scene.
  bool keep_points2d = true;
  // Without points3D features refer to no point, and the rest is that of the other files; see
  // ReadSparsePoints.
  bool keep_points3d = true;
};

// Whether the folder holds cameras, images and points3D, all as .bin or all as .txt.
bool IsSparseModelFolder(const std::filesystem::path& folder);
// What a folder that is none says of itself: "holds no sparse model (...)", or which of the three
// files it lacks.
std::string DescribeMissingModel(const std::filesystem::path& folder);

// Reads the model of COLMAP 3.x or 4.x in `folder`: binary if it is there, else text; rigs and
// frames if they are there. Throws InputError, with path and byte (binary) or line (text), for
// whatever does not fit: missing files, truncation or surplus at any byte, unknown camera models,
// numbers that are not finite, duplicate identifiers or names, images of missing cameras, frames
// that name missing images. Track elements that name an image or a feature that is not there, as
// converters write them, are dropped, and so are references of features to missing points; one
// sentence in `warnings` says how many. Memory never exceeds a small multiple of the files' sizes,
// whatever the counts in them say. Models without points or without images are legal here.
// O(bytes).
SparseModel ReadSparseModel(const std::filesystem::path& folder,
                            const ReadSparseModelOptions& options = {});

// Hands the points of the model in `folder` to `take`, in the file's order, with what
// ReadSparseModel drops and checks of them; `expect` hears before how many there are, if the file
// says so. `model` is what ReadSparseModel gave of the other files; `warnings` may get a sentence.
// Memory: 8 bytes a point. Throws what ReadSparseModel throws, perhaps after some points.
void ReadSparsePoints(const std::filesystem::path& folder, SparseModel* model,
                      const std::function<void(uint64_t)>& expect,
                      const std::function<void(SparseModel::Point3d)>& take);

// Writes cameras, images and points3D, and rigs and frames if the model has any; each file atomic,
// the folder is made if it is missing. Throws std::logic_error for an inconsistent model,
// FileSystemError if it cannot write.
void WriteSparseModel(const std::filesystem::path& folder, const SparseModel& model,
                      SparseFormat format = SparseFormat::kBinary);

// Logs what the reader had to leave out.
void LogWarnings(const SparseModel& model);

// Throws InputError(path, ...) for the first inconsistency that the readers' comment names. `path`
// is for the message.
void CheckSparseModel(const SparseModel& model, const std::filesystem::path& path);

}  // namespace lsmvs
