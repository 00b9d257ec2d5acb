#pragma once

#include <string>
#include <vector>

#include "lsmvs/pipeline/reconstruction_options.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/workflow/stage_options.h"

namespace lsmvs {

enum class CloudKind {
  kDense,   // fused.ply, or another cloud with its .vis
  kSparse,  // the points of the sparse model
};

// Clouds with visibility -> visibility-consistent mesh.
struct CloudMeshingRun {
  StageOptions stage;
  CloudKind input_type = CloudKind::kDense;
  // Workspaces or clouds; several, whose models are in one frame, are meshed as if they were one.
  std::vector<std::string> input_paths;
  // The mesh; beside it the views of its vertices, OUTPUT.vis.
  std::string output_path;
  // Unless empty: the one cloud without the points that the surface leaves in free space.
  std::string filtered_cloud_path;
  ReconstructionOptions reconstruction;

  void Describe(OptionSet* options);
};

// Plans, runs and shows the work as the functions of single_stages.h do. Throws UsageError for
// options that do not go together.
void MeshClouds(const CloudMeshingRun& options, const CommandContext& context);

}  // namespace lsmvs
