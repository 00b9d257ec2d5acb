#pragma once

#include <string>
#include <vector>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/run_plan.h"
#include "lsmvs/execution/run_store.h"
#include "lsmvs/execution/task.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What a stage of a run did.
struct StageSummary {
  std::string name;
  size_t num_ran = 0, num_up_to_date = 0, num_foreign = 0;
  double seconds = 0;       // of this run
  uint64_t peak_bytes = 0;  // highest resident size of the process meanwhile
  TaskCounts counts;        // summed over all tasks that are on record
};

// Told what goes on, from the thread that runs the tasks.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  // `fraction_done` of the stage's work needs not be done again.
  virtual void OnStageBegin(const PlannedStage& stage, double fraction_done) = 0;
  virtual void OnStageEnd(const StageSummary& summary) = 0;
  // A line on what happens beside the plan: a job that failed and is tried again.
  virtual void OnNote(const std::string& /*note*/) {}
  // Asked when the run is cancelled while so many of its jobs wait or run elsewhere: whether they
  // go on, to be picked up by the next start, or are cancelled.
  virtual bool KeepJobs(size_t /*num_jobs*/) { return false; }
};

// Runs the tasks that the plan (of these tasks) says, on the engine. Without one: in this process,
// one after the other, each with all threads of the context. What is done is on record when the
// next begins. A task whose inputs turn out not to have changed is skipped after all. Stages
// without a task to run are not reported. Progress of the context is that of the stage. Throws what
// a task throws, and CancelledError; what was finished stays. Outputs of temporary tasks are
// removed when the plan says.
std::vector<StageSummary> RunTasks(const std::vector<Task>& tasks, const RunPlan& plan,
                                   RunStore* store, RunObserver* observer,
                                   const RunContext& context, Engine* engine = nullptr);

}  // namespace lsmvs
