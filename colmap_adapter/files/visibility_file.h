#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "lsmvs/scene/visibility_cloud.h"

namespace lsmvs::internal {

// fused.ply.vis: for each point the images that see it, as positions in a list of images.
struct VisibilityFile {
  std::vector<uint64_t> begin = {0};  // #points + 1
  std::vector<uint32_t> image_idxs;   // of point p: begin[p] .. begin[p + 1]

  size_t num_points() const { return begin.size() - 1; }
};

// Throws InputError if the file is missing, truncated or too long, or if an index is not below
// `num_images`.
VisibilityFile ReadVisibilityFile(const std::filesystem::path& path, size_t num_images);
// The same behind the points that `file` holds already. Beside it nothing is held.
void AppendVisibilityFile(const std::filesystem::path& path, size_t num_images,
                          VisibilityFile* file);

}  // namespace lsmvs::internal
