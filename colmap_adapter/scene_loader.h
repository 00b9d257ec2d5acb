#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/sparse_model.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

struct LoadSceneOptions {
  // Folder with masks for some or all images, named as MaskPath() says; empty: no masks.
  std::string mask_folder = {};
  // Pixels with an alpha of 0 count as masked.
  bool alpha_is_mask = true;
  // Opens every image and mask file and compares its size with its camera's. Without it neither
  // needs to be there.
  bool check_images = true;
  // Images that are missing have View::has_photo false instead of being an error, as long as two
  // are there.
  bool skip_missing_images = false;
  // Takes cameras with distortion for PINHOLE: good enough where no pixel is looked up.
  bool ignore_distortion = false;
};

// The scene of a dense workspace. Views come in COLMAP's order of registered images
// (RegisteredImageOrder), so that a view_idx is an index of fused.ply.vis. SIMPLE_PINHOLE and
// PINHOLE cameras only.
//
// world_offset is zero for ordinary scenes. It is set to a round number near the scene's middle
// where the middle lies more than 100 times the scene's extent away from the origin, or where the
// spacing of floats there exceeds a hundredth of a pixel on the surface.
//
// Throws InputError as ReadSparseModel does, and if no image is registered, a camera is distorted
// or panoramic, images/ is missing, image files are missing (the message counts and names them, and
// tells those that are there under a similar name), an image or mask is corrupt (unreadable header,
// cut off) or of another size than its camera, or the mask folder is missing. An empty points3D is
// legal. O(model) time; image files are not decoded.
Scene LoadScene(const DenseWorkspace& workspace, const LoadSceneOptions& options = {});

// The same from a model in memory, without looking at image files. `model_path` is for messages.
Scene MakeScene(const SparseModel& model, const std::filesystem::path& model_path,
                bool ignore_distortion = false);

}  // namespace lsmvs
