#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/run_context.h"
#include "lsmvs/util/shared_loop.h"

namespace lsmvs {

// Figures that a task reports, for the run record: "points" -> 123456.
using TaskCounts = std::map<std::string, double>;

// What to do with output files that are there but were not made by us.
enum class ForeignOutputs {
  kRefuse,  // stop with ExitCode::kOverwrite
  kUse,     // if all outputs are there, they take the place of the task's; if only some are, refuse
};

// What a task runs with.
struct TaskRun {
  const RunContext& context;
  // Where to write: one path for each of Task::outputs, in that order, of the same file name. The
  // files appear under their own names, all together, when the task has returned.
  const std::vector<std::filesystem::path>& outputs;
  // Announces a file beyond Task::outputs, for what only the run knows the number of; returns where
  // to write it. It appears with the others. Throws Error(kOverwrite) where a file of somebody else
  // is in the way.
  std::function<std::filesystem::path(const std::filesystem::path& output)> add_output = {};
  // Where a task with checkpoint_bytes keeps what its finished steps gave (CheckpointFolder): of
  // this task, these inputs, options and version only. Empty: nowhere. It is there if an earlier
  // run of the same was killed, and removed when the task has ended.
  std::filesystem::path checkpoint_folder = {};
};

// A step of a run: files in, files out. What it computes must depend on nothing but the contents of
// `inputs`, `options` and `version`; then a rerun may skip it, and a run that was killed ends with
// the same bytes as one that was not.
struct Task {
  std::string stage;  // tasks of a stage follow each other and share a line in the plan and the
                      // progress: "stereo_fusion"
  std::string name;   // unique in a run: "stereo_fusion", "patch_match_stereo/geometric/IMG_1.jpg"
  std::string version;                         // of the method: another one makes old results stale
  std::string options;                         // "name=value" lines (OptionSet::ToText)
  std::vector<std::filesystem::path> inputs;   // exist when the task starts
  std::vector<std::filesystem::path> outputs;  // of no other task
  ForeignOutputs foreign_outputs = ForeignOutputs::kRefuse;
  // Somebody wants the outputs themselves. Other tasks only run when one that is wanted needs their
  // outputs.
  bool wanted = true;
  // The outputs serve later tasks only: each is removed once all tasks that read it are done.
  bool temporary = false;
  CostEstimate cost;
  // What the task holds in large blocks may lie partly in a scratch file (ScratchMemory) where it
  // does not fit into memory. 0: it may not. Else the least memory with which that makes sense.
  size_t least_bytes = 0;
  // What the task keeps of its finished steps on disk when it works with a scratch file, so that a
  // run that is killed goes on behind them.
  uint64_t checkpoint_bytes = 0;
  uint64_t output_bytes = 0;  // that the outputs take on disk, about
  // Sets cost and sizes again from a look at the inputs, where that takes too long to be done for
  // tasks that need not run. May be empty.
  std::function<void(Task* task)> measure_cost = {};
  std::function<TaskCounts(const TaskRun&)> run;
  // Other machines can take part in the task's loops (RunContext::helpers): so many at most are of
  // use. What they run is this; it lives no longer than the context.
  size_t max_helpers = 0;
  std::function<std::unique_ptr<LoopWorker>(const RunContext& context)> make_worker = {};
};

}  // namespace lsmvs
