#include "lsmvs/pipeline/tasks/task_inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "lsmvs/util/error.h"

namespace lsmvs {

void AddModelInputs(const Reconstruction& reconstruction, Task* task) {
  const auto files = reconstruction.files->ModelFiles();
  task->inputs.insert(task->inputs.end(), files.begin(), files.end());
  if (reconstruction.has_source_rules) {
    task->inputs.push_back(reconstruction.files->SourceRulesFile());
  }
}

void AddPhotoInputs(const Reconstruction& reconstruction, int view_idx, Task* task) {
  const ImageSource& source = reconstruction.images->source(view_idx);
  if (source.is_missing) return;
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

void CheckAnyNeighbors(const Reconstruction& reconstruction) {
  const auto& lists = reconstruction.neighbors;
  if (std::any_of(lists.begin(), lists.end(), [](const auto& list) { return !list.empty(); })) {
    return;
  }
  const int num_views = reconstruction.scene.num_views();
  throw InputError(
      reconstruction.files->ModelFiles().front().parent_path().string(),
      num_views == 1 ? "has one photo, and depth takes two at least"
                     : fmt::format("none of its {} photos has another that shows the same from "
                                   "elsewhere: too few points in common, or the same place",
                                   num_views),
      num_views == 1 ? "take more photos of what it shows"
                     : "check the sparse model, or list sources in stereo/patch-match.cfg");
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
  return fmt::format("max_image_size={}\nseed={}\n{}", reconstruction.options.max_image_size,
                     reconstruction.options.seed,
                     reconstruction.scene.alpha_is_mask ? "" : "alpha_is_mask=0\n");
}

}  // namespace lsmvs
