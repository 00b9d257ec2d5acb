#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "lsmvs/execution/run_record.h"
#include "lsmvs/execution/task.h"

namespace lsmvs {

// Where and with what a task runs, be it in the driver or in a job.
struct TaskSite {
  std::filesystem::path root;  // of the run
  std::filesystem::path scratch_folder;
  // As in PlannedTask and RunPlan.
  size_t resident_bytes = 0, process_bytes = 0;
  // Where an output is written before it gets its name.
  std::function<std::filesystem::path(const std::filesystem::path& output)> staged_path;
  // Throws if a file is in the way that the task adds to its outputs.
  std::function<void(const std::filesystem::path& output)> check_added;
};

// Of a task that has run: its results lie at their staged paths.
struct FinishedTask {
  TaskRecord record;                           // without outputs
  std::vector<std::filesystem::path> outputs;  // Task::outputs, then those that the run added
};

// Runs the task. `keep` is called with what it gave; what is still at the staged paths when it has
// returned, or after an exception, is removed. Checkpoints of the task are kept until then, but for
// an InputError, which would come again.
void RunTask(const Task& task, const std::string& inputs_hash, const TaskSite& site,
             const RunContext& context, const std::function<void(FinishedTask)>& keep);

// Removes checkpoints of a task that need not run: a run that was killed between its last two steps
// has left them.
void RemoveCheckpoints(const Task& task, const std::filesystem::path& root,
                       const std::filesystem::path& scratch_folder);

}  // namespace lsmvs
