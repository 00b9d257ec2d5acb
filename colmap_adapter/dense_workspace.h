#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// As in the names of the files: "photometric" or "geometric".
std::string ToString(DepthMapKind kind);

// A dense workspace as COLMAP's image_undistorter makes it, and the one place that knows the names
// of all files in it. Functions do not look at the disk unless they say so.
struct DenseWorkspace {
  std::filesystem::path folder;

  // The sparse model's folder: sparse/, or sparse/0 where only that holds a model, or the folder
  // itself where it holds a model and no sparse/. Looks at the disk.
  std::filesystem::path SparseFolder() const;
  // The model's file of that name, "cameras" or "points3D": binary is preferred, as when reading.
  std::filesystem::path ModelFile(const std::string& name) const;
  // Those of the model's files that are there.
  std::vector<std::filesystem::path> ModelFiles() const;
  std::filesystem::path ImageFolder() const { return folder / "images"; }
  std::filesystem::path ImagePath(const std::string& image_name) const {
    return ImageFolder() / image_name;
  }
  std::filesystem::path StereoFolder() const { return folder / "stereo"; }
  std::filesystem::path DepthMapPath(const std::string& image_name, DepthMapKind type) const;
  std::filesystem::path NormalMapPath(const std::string& image_name, DepthMapKind type) const;
  std::filesystem::path PatchMatchConfigPath() const { return StereoFolder() / "patch-match.cfg"; }
  std::filesystem::path FusionConfigPath() const { return StereoFolder() / "fusion.cfg"; }

  std::filesystem::path FusedPath() const { return folder / "fused.ply"; }
  // COLMAP's rule: the visibility of a cloud lies beside it, with ".vis" appended.
  static std::filesystem::path VisibilityPath(const std::filesystem::path& fused_path);

  // COLMAP's meshes, which we compare with and never write.
  std::filesystem::path PoissonMeshPath() const { return folder / "meshed-poisson.ply"; }
  std::filesystem::path DelaunayMeshPath() const { return folder / "meshed-delaunay.ply"; }
  // Ours.
  std::filesystem::path VisibilityMeshPath() const { return folder / "meshed-visibility.ply"; }
  std::filesystem::path RefinedMeshPath() const { return folder / "meshed-refined.ply"; }

  // As COLMAP's mesh_texturer names it; its pages, texture.png and so on, lie beside it.
  std::filesystem::path TexturedMeshPath() const { return folder / "textured" / "mesh.ply"; }

  std::filesystem::path RunFolder() const { return folder / "lsmvs"; }
  std::filesystem::path RunRecordPath() const { return RunFolder() / "run.json"; }
  std::filesystem::path ReportFolder() const { return RunFolder() / "report"; }
  std::filesystem::path LogFolder() const { return RunFolder() / "logs"; }
};

// Whether `folder` holds a sparse model and a sign of dense work: stereo/, fused.ply or lsmvs/.
// Without such a sign the photos may still be distorted, and the folder is a project. images/ need
// not be there: a cloud can be meshed without.
bool IsDenseWorkspace(const std::filesystem::path& folder);

// A dense workspace that is there, or that can be made by undistorting a sparse model.
struct WorkspaceEntry {
  DenseWorkspace workspace;
  bool exists = false;
  // Where it is to be made from; empty if it exists and its model is not there any more.
  std::filesystem::path sparse_folder, image_folder;
};

// Finds the workspaces that `path` stands for:
//   a dense workspace                                            -> itself
//   a project (images/ and sparse/0..N, or a model in sparse/)   -> dense/0..N, there already or to
//   be made what automatic_reconstructor leaves (dense/0..N)             -> those, and the ones
//   missing for sparse/0..N a folder of dense workspaces (0..N)                          -> those
// in ascending order of N. `image_folder` replaces <path>/images of a project; may be empty. Throws
// InputError that says what was looked for if `path` is none of these, or if a dense/N is in the
// way that is not a workspace.
std::vector<WorkspaceEntry> FindDenseWorkspaces(const std::filesystem::path& path,
                                                const std::filesystem::path& image_folder = {});

}  // namespace lsmvs
