#include "lsmvs/pipeline/task_inputs.h"

#include <fmt/format.h>

namespace lsmvs {

void AddModelInputs(const Reconstruction& reconstruction, Task* task) {
  const auto files = reconstruction.files->ModelFiles();
  task->inputs.insert(task->inputs.end(), files.begin(), files.end());
}

void AddPhotoInputs(const Reconstruction& reconstruction, int view_idx, Task* task) {
  const ImageSource& source = reconstruction.images->source(view_idx);
  task->inputs.emplace_back(source.path);
  if (!source.mask_path.empty() && std::filesystem::exists(source.mask_path)) {
    task->inputs.emplace_back(source.mask_path);
  }
}

void AddAllPhotoInputs(const Reconstruction& reconstruction, Task* task) {
  for (int i = 0; i < reconstruction.scene.num_views(); ++i)
    AddPhotoInputs(reconstruction, i, task);
}

void AddDepthMapInputs(const Reconstruction& reconstruction, int view_idx, DepthMapKind kind,
                       Task* task) {
  const View& view = reconstruction.scene.views[static_cast<size_t>(view_idx)];
  for (const auto& path : reconstruction.files->DepthMapFiles(view, kind)) {
    task->inputs.push_back(path);
  }
}

std::string BoxText(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return "";
  return fmt::format("{} {} {} {} {} {}", box.min().x(), box.min().y(), box.min().z(),
                     box.max().x(), box.max().y(), box.max().z());
}

std::string EmptyCloudRemedy(const Reconstruction& reconstruction) {
  std::string remedy = "check that the photos overlap and show texture";
  if (!reconstruction.scene.mask_folder.empty()) remedy += ", that --mask_path leaves some of them";
  if (!reconstruction.options.bounding_box.isEmpty()) {
    remedy += ", that --bounding_box holds some of the sparse points";
  }
  return remedy;
}

std::string internal::SharedOptionsText(const Reconstruction& reconstruction) {
  return fmt::format("max_image_size={}\nseed={}\n", reconstruction.options.max_image_size,
                     reconstruction.options.seed);
}

}  // namespace lsmvs
