#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/execution/engine.h"
#include "lsmvs/pipeline/reconstruction_options.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

// COLMAP's --workspace_format. We know its own format only.
enum class DenseFormat { kColmap };

// Options that the commands for single stages share.
struct StageOptions {
  std::string workspace_path;
  DenseFormat format = DenseFormat::kColmap;
  std::string mask_path;
  std::string database_path;
  Eigen::AlignedBox3d bounding_box;
  int max_image_size = -1;  // as COLMAP's: -1 or 0 is the full size
  bool overwrite = false;
  bool alpha_is_mask = true;
  bool skip_missing_images = false;
  std::string sources_path;  // COLMAP's --config_path
  std::string box_path;      // COLMAP's --bbox_path
  bool ignore_disk_space = false;
  std::string scratch_path;
  int num_parts = 1;
  bool keep_photometric_maps = true;
  MapPrecision map_precision = MapPrecision::kExact;
  EngineOptions engine;

  void DescribeWorkspace(OptionSet* options);
  void DescribeMaskPath(OptionSet* options);
  void DescribeAlphaMask(OptionSet* options);
  void DescribeSkipMissingImages(OptionSet* options);
  void DescribeSourcesPath(OptionSet* options);
  void DescribeBoxPath(OptionSet* options);
  void DescribeDatabasePath(OptionSet* options);
  void DescribeBoundingBox(OptionSet* options);
  // `name`: COLMAP's, with the stage's group.
  void DescribeMaxImageSize(const std::string& name, OptionSet* options);
  // How the run is done: overwrite, ignore_disk_space, engine and its options.
  void DescribeRun(OptionSet* options);

  // Where and how stages work on disk that do not fit into memory: scratch_path, num_parts.
  void DescribeScratch(OptionSet* options);
  // What stages that work on a mesh with photos share: photos, how results are written, scratch.
  void DescribeMeshStage(OptionSet* options);
  // How depth maps are kept: keep_photometric_maps, of which `keep` is the default, and map_format.
  void DescribeMaps(bool keep, OptionSet* options);

  // Puts what concerns all stages into their options.
  void Apply(ReconstructionOptions* options) const;
  // The database whose features may join the interest points of the workspace; empty if none.
  std::filesystem::path Database(const DenseWorkspace& workspace) const;
  DenseWorkspace Workspace() const { return DenseWorkspace{workspace_path}; }
};

}  // namespace lsmvs
