#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/colmap_adapter/colmap_runner.h"
#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct MaskOptions {
  std::string mask_folder;  // as MaskPath(); empty: none
  bool alpha_is_mask = true;
};

// Masks of a project's photos belong to the photos as they were taken, those of a dense workspace
// to its undistorted images. Undistorts the project's masks, and the alpha channels of its photos,
// with `colmap image_undistorter`, as it did the photos, into lsmvs/masks of the entry's workspace,
// which must exist. Returns the folder of the masks that fit the workspace's images: lsmvs/masks;
// options.mask_folder as it is if the entry is no project's; empty if there are no masks. What
// lies outside of the photo is masked. Masks of the size of the undistorted image, where that
// differs from the photo's, are taken as they are. Nothing is done when model, masks and photos are
// those that lsmvs/masks was made from.
//
// Throws InputError for masks that cannot be decoded or have another size than their photo,
// ExternalToolError, CancelledError.
std::string PrepareMasks(const WorkspaceEntry& entry, const MaskOptions& options,
                         const ColmapRunner& runner, const RunContext& context);

}  // namespace lsmvs
