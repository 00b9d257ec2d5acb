#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/colmap_adapter/sparse_model.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What of COLMAP's is written beside the photos.
enum class WorkspaceFormat {
  kPhotos,   // nothing: images/ alone, for a run of COLMAP from the start
  kProject,  // sparse/0: what `colmap mapper` leaves
  kDense,    // sparse/ and stereo/: what `colmap image_undistorter` leaves
};

// The sparse model of COLMAP: one PINHOLE camera, images with exact poses, the scene's sparse
// points with their tracks (features are the exact projections).
SparseModel MakeSparseModel(const Scene& scene);

// The surface that the views can see of the shape: its mesh without the faces that lie inside of
// other parts.
TriangleMesh TruthMesh(const SyntheticScene& scene);

// Writes a truth folder: gt_mesh.ply and camera_centers.txt (lines "name x y z", as `colmap
// model_aligner --ref_images_path` reads them).
void WriteTruth(const std::filesystem::path& folder, const SyntheticScene& scene);

// Renders the photos to <folder>/images with scene->photo, and writes the model of the format and
// the truth to <folder>. Sets scene->scene.image_folder.
void WriteWorkspace(const std::filesystem::path& folder, WorkspaceFormat format,
                    SyntheticScene* scene, const RunContext& context);

}  // namespace lsmvs
