#include <fmt/format.h>

#include "lsmvs/colmap_adapter/files/binary_reader.h"
#include "lsmvs/colmap_adapter/files/visibility_file.h"

namespace lsmvs::internal {

namespace {

constexpr const char* kRemedy =
    "run `stereo_fusion` again: it writes fused.ply and fused.ply.vis together";

void ReadImagesOfPoint(size_t num_images, BinaryReader* reader, VisibilityFile* file) {
  const size_t first = file->image_idxs.size();
  const auto count =
      static_cast<size_t>(reader->ReadCount<uint32_t>(sizeof(uint32_t), "images of a point"));
  file->image_idxs.resize(first + count);
  const uint64_t position = reader->Position();
  reader->ReadBytes(file->image_idxs.data() + first, count * sizeof(uint32_t));
  for (size_t i = first; i < file->image_idxs.size(); ++i) {
    if (file->image_idxs[i] < num_images) continue;
    reader->FailAt(fmt::format("names image {}, but the sparse model has {} images",
                               file->image_idxs[i], num_images),
                   position + (i - first) * sizeof(uint32_t));
  }
  file->begin.push_back(file->image_idxs.size());
}

}  // namespace

VisibilityFile ReadVisibilityFile(const std::filesystem::path& path, size_t num_images) {
  VisibilityFile file;
  AppendVisibilityFile(path, num_images, &file);
  return file;
}

void AppendVisibilityFile(const std::filesystem::path& path, size_t num_images,
                          VisibilityFile* file) {
  BinaryReader reader(path, kRemedy);
  const uint64_t num_points = reader.ReadCount<uint64_t>(sizeof(uint32_t), "points");
  file->begin.reserve(file->begin.size() + static_cast<size_t>(num_points));
  // What is left beside the counts are indices; a corrupt count cannot make this more than the
  // file.
  const auto num_indices = static_cast<size_t>(reader.Remaining() / sizeof(uint32_t) - num_points);
  file->image_idxs.reserve(file->image_idxs.size() + num_indices);
  for (uint64_t i = 0; i < num_points; ++i) ReadImagesOfPoint(num_images, &reader, file);
  reader.ExpectEnd();
}

}  // namespace lsmvs::internal
