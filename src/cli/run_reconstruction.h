#pragma once

#include <vector>

#include "lsmvs/cli/command.h"
#include "lsmvs/cli/plan_text.h"
#include "lsmvs/cli/stage_options.h"
#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/execution/task.h"
#include "lsmvs/pipeline/reconstruction.h"

namespace lsmvs {

// Loads the workspace's scene and sets up what its tasks share. Of `stage` the masks and the
// database are used.
ReconstructionPtr OpenReconstruction(const DenseWorkspace& workspace, const StageOptions& stage,
                                     const ReconstructionOptions& options,
                                     const CommandContext& context);

// Prints the plan, refuses it if it does not fit the memory or the disk, runs it with progress, and
// prints what is there now.
void RunPlanned(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                const std::vector<Task>& tasks, const StageOptions& stage,
                const CommandContext& context);

}  // namespace lsmvs
