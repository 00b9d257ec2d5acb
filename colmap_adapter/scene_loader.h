#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/sparse_model.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

struct LoadSceneOptions {
  // Folder with a mask <image name>.png for some or all images; empty: no masks.
  std::string mask_folder = {};
  // Opens every image file and compares its size with its camera's.
  bool check_images = true;
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
// or panoramic, images/ is missing, an image file is missing, corrupt (unreadable header, cut off)
// or of another size than its camera, or the mask folder is missing. An empty points3D is legal.
// O(model) time; image files are not decoded.
Scene LoadScene(const DenseWorkspace& workspace, const LoadSceneOptions& options = {});

// The same from a model in memory, without looking at image files. `model_path` is for messages.
Scene MakeScene(const SparseModel& model, const std::filesystem::path& model_path);

}  // namespace lsmvs
