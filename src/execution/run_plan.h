#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "lsmvs/execution/run_store.h"
#include "lsmvs/execution/task.h"

namespace lsmvs {

enum class TaskState {
  kRun,        // something changed or is missing
  kUpToDate,   // inputs, options and version are those of the results that are there
  kForeign,    // somebody else's files stand in the place of the outputs and are used
  kNotNeeded,  // nobody wants the outputs
};

struct PlannedTask {
  TaskState state = TaskState::kNotNeeded;
  std::string reason;  // of kRun: "new", "options changed", "input changed", ...
  // Memory of a task that works with a scratch file; 0: it has all in memory.
  size_t resident_bytes = 0;
};

struct PlannedStage {
  std::string name;
  size_t begin = 0, end = 0;  // its tasks' positions
  size_t num_run = 0, num_up_to_date = 0, num_foreign = 0;
  std::string reason;          // of the first task that runs
  CostEstimate cost;           // of the tasks that run: sum of times, highest memory
  uint64_t scratch_bytes = 0;  // the largest scratch file of one, with its checkpoints
  uint64_t output_bytes = 0;   // that they write
};

struct RunPlan {
  bool overwrite = false;          // see PlanOptions
  std::vector<PlannedTask> tasks;  // one for each task given, in that order
  std::vector<PlannedStage> stages;
  // For each task, the temporary ones whose outputs nobody needs any more once it is done.
  std::vector<std::vector<size_t>> drops;
  // Temporary ones whose outputs nobody needs any more from the start: an earlier run was stopped
  // before it removed them.
  std::vector<size_t> leftovers;
  // By which the files grow while it runs, at most, beyond what is there already.
  uint64_t peak_disk_bytes = 0;
  // The largest scratch file of a task, with its checkpoints.
  uint64_t peak_scratch_bytes = 0;
  std::filesystem::path scratch_folder;  // as in the options
  size_t process_bytes = 0;              // as in the options

  // Time summed over the stages, highest memory of one.
  CostEstimate Cost() const;
  size_t NumToRun() const;
};

struct PlanOptions {
  // Replace files that are not ours instead of using or refusing them.
  bool overwrite = false;
  // Tasks that need more work with a scratch file, where they can.
  size_t memory_bytes = std::numeric_limits<size_t>::max();
  size_t process_bytes = 0;  // that the process takes beside the tasks
  // Where scratch files go.
  std::filesystem::path scratch_folder;
  // Above 1: those that can have no more in memory than this part of what they need.
  int num_parts = 1;
};

// Decides what to run: a task whose outputs are wanted, or needed by a task that runs, unless they
// are up to date. Intermediate files that are gone count as they were while their task is
// unchanged, so that they may be deleted to save space. Tasks come in an order in which they can
// run; those of one stage are neighbours. Throws Error(kOverwrite) where a foreign file is in the
// way, InputError where an input is missing or an output
// is a folder. Reads new or changed input files once, to hash them.
RunPlan PlanRun(const std::vector<Task>& tasks, const PlanOptions& options, RunStore* store);

// Has the tasks that will run and whose inputs are there, as they will be then, measure their
// costs. True if one did: the plan is to be made again.
bool MeasureCosts(const RunPlan& plan, std::vector<Task>* tasks);

// The hash that TaskRecord::inputs_hash holds, from the files as they are on disk.
std::string HashInputs(const Task& task, FileTable* files);

// Throws Error(kOverwrite) if a file is there that is not ours.
void CheckReplaceable(const std::filesystem::path& output, FileTable* files);

// Why the task has to run, all its inputs being there; empty if it is up to date.
std::string ReasonToRun(const Task& task, RunStore* store);

}  // namespace lsmvs
