#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "lsmvs/colmap_adapter/colmap_runner.h"
#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct PrepareWorkspaceOptions {
  // Longer side of the undistorted images, pixels; passed on to image_undistorter. Not set: full
  // size. Workspaces that exist are taken as they are.
  std::optional<int> max_image_size;
  // Photos of a project, if they do not lie in its images/.
  std::filesystem::path image_folder = {};
  // Photos of the model that are missing are left out of the workspace instead of being an error.
  bool skip_missing_images = false;
};

// Makes the workspace by `colmap image_undistorter`, unless it exists. The work goes on in a hidden
// folder beside it, which is renamed when it is complete: a killed run leaves no half workspace,
// and the next one starts over. COLMAP is given a binary copy of a model that is text (its
// text reader cuts names at blanks), refers to what is not there or loses images. COLMAP's output
// is kept beside the workspace in image_undistorter-<its name>.log. Throws ExternalToolError if
// colmap is missing or fails, CancelledError; InputError for a model of fewer than two photos
// (nothing can be matched) and for missing photos.
DenseWorkspace PrepareDenseWorkspace(const WorkspaceEntry& entry, const ColmapRunner& runner,
                                     const PrepareWorkspaceOptions& options,
                                     const RunContext& context);

// FindDenseWorkspaces, then the above for each.
std::vector<DenseWorkspace> PrepareDenseWorkspaces(const std::filesystem::path& path,
                                                   const ColmapRunner& runner,
                                                   const PrepareWorkspaceOptions& options,
                                                   const RunContext& context);

}  // namespace lsmvs
