#pragma once

#include <vector>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/workspace_files.h"
#include "lsmvs/execution/task.h"
#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/workflow/planning/plan_text.h"
#include "lsmvs/workflow/stage_options.h"

namespace lsmvs {

// What the tasks will look at of the photos.
enum class PhotoUse {
  kPixels,    // their pixels: they must be there, with cameras without distortion
  kNothing,   // nothing but where they were taken from and how large they are
  kNoCamera,  // the same, and distortion does not matter either
};

// Loads the workspace's scene and sets up what its tasks share. Of `stage` the masks, the database,
// the list of sources and what concerns missing photos are used.
ReconstructionPtr OpenReconstruction(const DenseWorkspace& workspace, const StageOptions& stage,
                                     const ReconstructionOptions& options,
                                     const CommandContext& context,
                                     PhotoUse photos = PhotoUse::kPixels);

// Several workspaces in one frame as one (see MakeJoinedWorkspaceFiles); no photo is looked at.
// Prints which numbers the photos of each have.
ReconstructionPtr OpenJoinedReconstruction(const DenseWorkspace& output,
                                           const std::vector<CloudInput>& inputs,
                                           const ReconstructionOptions& options,
                                           const CommandContext& context, PhotoUse photos);

// Whether there is something to do in the workspace: in a job, if it is the job's.
bool IsWanted(const DenseWorkspace& workspace, const CommandContext& context);

// In a job runs its tasks. Else prints the plan, refuses it if it does not fit the memory or the
// disk, runs it with progress, and prints what is there now.
void RunPlanned(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                std::vector<Task> tasks, const StageOptions& stage, const CommandContext& context);

// The same for the tasks of one stage, the last of which writes its result, or for a single task.
// `usual_output`: where the pipeline writes it; tasks for a result elsewhere are others on record.
void RunPlannedTasks(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                     std::vector<Task> tasks, const std::filesystem::path& usual_output,
                     const StageOptions& stage, const CommandContext& context);
void RunPlannedTask(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                    Task task, const std::filesystem::path& usual_output, const StageOptions& stage,
                    const CommandContext& context);

}  // namespace lsmvs
