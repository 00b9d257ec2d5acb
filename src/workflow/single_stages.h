#pragma once

#include <string>

#include "lsmvs/pipeline/reconstruction_options.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/scene/depth_map.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/workflow/stage_options.h"

namespace lsmvs {

// One stage of a reconstruction, in the workspace `stage.workspace_path`: each function loads the
// scene, prints the plan, refuses what does not fit the memory or the disk, runs the stage with
// progress and prints what is there now. What is up to date is not done again; a stopped run goes
// on where it was. In a job only the job's tasks are run. Throw UsageError for options out of range
// and what the stage throws.

// Photos -> depth and normal maps in stereo/.
struct PatchMatchStereoRun {
  StageOptions stage;
  ReconstructionOptions reconstruction;

  void Describe(OptionSet* options);
};
void RunPatchMatchStereo(const PatchMatchStereoRun& options, const CommandContext& context);

// COLMAP's --output_type of clouds and of textured meshes. We write the one that others read.
enum class PlyOnly { kPly };

// Depth and normal maps -> cloud with visibility.
struct StereoFusionRun {
  StageOptions stage;
  DepthMapKind input_type = DepthMapKind::kGeometric;
  std::string output_path;
  PlyOnly output_type = PlyOnly::kPly;
  ReconstructionOptions reconstruction;

  void Describe(OptionSet* options);
};
void RunStereoFusion(const StereoFusionRun& options, const CommandContext& context);

// Photos -> cloud with visibility, by interest points.
struct QuasiDenseRun {
  StageOptions stage;
  std::string output_path;
  ReconstructionOptions reconstruction;

  void Describe(OptionSet* options);
};
void RunQuasiDenseMatcher(const QuasiDenseRun& options, const CommandContext& context);

// Mesh and photos -> refined mesh.
struct MeshRefinementRun {
  StageOptions stage;
  std::string input_path, output_path;
  ReconstructionOptions reconstruction;

  void Describe(OptionSet* options);
};
void RunMeshRefiner(const MeshRefinementRun& options, const CommandContext& context);

// Mesh and photos -> textured mesh: mesh.ply and its pages in the folder `output_path`.
struct MeshTexturingRun {
  StageOptions stage;
  std::string input_path, output_path;
  PlyOnly output_type = PlyOnly::kPly;
  ReconstructionOptions reconstruction;

  void Describe(OptionSet* options);
};
void RunMeshTexturer(const MeshTexturingRun& options, const CommandContext& context);

}  // namespace lsmvs
