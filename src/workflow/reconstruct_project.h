#pragma once

#include <optional>
#include <string>

#include "lsmvs/pipeline/reconstruction_options.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/workflow/stage_options.h"

namespace lsmvs {

// From what `colmap mapper` leaves to a refined mesh: the options of lsmvs-mesher.
struct ProjectReconstructionOptions {
  // Of `stage`: workspace_path is a project, a folder that automatic_reconstructor made, or a dense
  // workspace. Masks are those of a project's photos, or of a dense workspace's undistorted ones.
  StageOptions stage;
  // Photos of a project that do not lie in its images/.
  std::string image_path;
  Quality quality = Quality::kHigh;
  std::optional<PointSource> point_source;  // nothing: what the quality says
  std::optional<int> max_image_size;        // the same; -1: as they are
  // First and last stage; nothing: the source's first one, and refinement.
  std::optional<ReconstructionStage> from, to;
  bool texture = false;  // go on to texturing
  bool report = false;   // end with the page of mesh_comparer
  ReconstructionOptions reconstruction;

  void Describe(OptionSet* options);
  // What quality and point_source decide.
  void ApplyPresets();
};

// Undistorts the models of a project by `colmap`, where that is not done, and takes each dense
// workspace through the stages; see single_stages.h for what each run does. A model that fails for
// its input does not keep the others from being done. Throws UsageError, and in the end the first
// such error.
void ReconstructProject(const ProjectReconstructionOptions& options, const CommandContext& context);

}  // namespace lsmvs
