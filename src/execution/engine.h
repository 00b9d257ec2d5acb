#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/execution/run_plan.h"
#include "lsmvs/execution/run_store.h"
#include "lsmvs/execution/task.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// One run on one or on many machines.
//
// A run is a static graph of tasks over files. RunTasks() takes its stages one after the other and
// hands each to an Engine, of which there are three: this process (local), Slurm, and any other job
// system by way of a list of commands. Stages do not know which.
//
// The two that use other processes share one driver (jobs/job_engine.cc). Tasks that are ready are
// grouped into slices of some minutes that read the same photos; a slice is a job, and jobs of
// equal needs are submitted together as a batch (an array job). With a queue, further jobs are
// submitted before the machines have finished those that run, and a task may start as soon as the
// tasks that it needs are done; else one batch follows the other. A job is the command `lsmvs
// run_task WORKSPACE --task BATCH.SLICE`: it reads the order of the batch (the command line that
// the driver was started with, the names of the tasks, and a hash of what each depends on), builds
// the same tasks from the same command line, runs its own, one after the other, and leaves for each
// the finished files and a record in the folder of its slice, which no other job writes to:
//   <root>/lsmvs/jobs/<batch>/order.json       by the driver, before it submits
//   <root>/lsmvs/jobs/<batch>/handle           what the job system calls the batch
//   <root>/lsmvs/jobs/<batch>/<slice>.log      what the job printed
//   <root>/lsmvs/jobs/<batch>/<slice>/<k>.json record of the slice's task k, written last
//   <root>/lsmvs/jobs/<batch>/<slice>/files/   its outputs
//   <root>/lsmvs/jobs/<batch>/<slice>/progress share that is done, every two seconds
//   <root>/lsmvs/jobs/<batch>/<slice>/leader   how the slice's helpers reach it
// A task that cannot be divided, because each of its steps needs all of the one before, shares the
// loops of its steps with helpers (helper_leader.h): further jobs of its batch. They read the same
// files, connect to the task's job, and compute what it hands out. They write nothing. Whether they
// come, when, and how they end, makes no difference to the result.
// The driver looks for records, renames the files to where they belong and puts the task on record:
// run.json has one writer. The contents of a task's inputs are what they were when it was
// submitted, or its result is thrown away. Hence the same bytes as a local run, however often jobs,
// nodes and the driver die:
//   a job that fails, or whose node dies   what it has finished counts; the rest is submitted anew
//                                          in a new folder, up to max_attempts times
//   memory or time was too short           the same, with more of it
//   a task that finds its input wrong      ends the run, with the message of the task
//   a job that somebody else cancels       ends the run: it is not submitted against their will
//   a driver that is killed                jobs go on; the next start finds their folders, collects
//                                          what is done and watches those that still run
//   Ctrl-C                                 the observer is asked (RunObserver::KeepJobs); jobs of
//                                          this run are cancelled by their numbers, no others
// Whether a job has ended is asked from the job system; where it has forgotten the job, and no
// record appears within some time, the job counts as lost.
enum class EngineKind { kLocal, kSlurm, kCommand };

struct EngineOptions {
  EngineKind kind = EngineKind::kLocal;
  // Length that jobs of short tasks are to have [minutes].
  double job_minutes = 5;
  // How often a task is started before the run gives up.
  int max_attempts = 3;
  // Slurm's options of the same names; empty: what the cluster takes by default.
  std::string partition, account;
  // Limit of each job, as Slurm writes it; empty: from the plan.
  std::string time;
  // Jobs of this run that run at once, at most.
  int max_jobs = 100;
  // Further options of sbatch, as one would type them.
  std::string extra;
  // Command line, for sh, that runs a batch's jobs and returns when all have ended. It is given
  //   {commands}  file with the command of one job a line
  //   {script}    program that runs the job whose number (from 1) is its argument, or in
  //               PBS_ARRAY_INDEX, PBS_ARRAYID, SGE_TASK_ID or SLURM_ARRAY_TASK_ID
  //   {count}     number of jobs
  //   {folder}    of the batch
  //   {threads}, {memory_mb}, {seconds}   what one job needs
  std::string submit_command;
  // How many jobs the command runs at once, about: work is divided accordingly.
  int jobs_at_once = 8;

  // Adds the options as the command line has them: "engine", "Slurm.partition", ...
  void Describe(OptionSet* options);
  // Bounds, and that they fit together.
  bool Check(std::string* error) const;
};

// The command that a job repeats.
struct DriverCommand {
  std::string program;                 // that runs `run_task`: path of lsmvs
  std::string name;                    // of the command: "lsmvs-mesher", "stereo_fusion"
  std::vector<std::string> arguments;  // as typed
};

// What a job may ask for at most, as far as the job system says.
struct JobLimits {
  int num_threads = 1;
  size_t memory_bytes = 0;     // 0: unknown
  int num_threads_in_all = 1;  // of all machines
};

// How a stage is divided.
struct StageDivision {
  size_t num_jobs = 0;      // 0: the stage runs in this process
  int num_threads = 1;      // of a job
  size_t memory_bytes = 0;  // that a job asks for
  double job_seconds = 0;   // that a job takes, about
  size_t jobs_at_once = 1;  // at most
  size_t num_helpers = 0;   // further jobs that take part in a single one
};

// Jobs of the stage at hand, as they are known at present.
struct JobCounts {
  size_t waiting = 0, running = 0;
  std::string reason;  // why the first one waits
  std::string nodes;   // where jobs run
};

struct StageSummary;
class RunObserver;

// A stage's work, as an engine sees it.
class StageWork {
 public:
  virtual ~StageWork() = default;
  virtual const std::vector<Task>& tasks() const = 0;
  virtual const RunPlan& plan() const = 0;
  virtual const PlannedStage& stage() const = 0;
  virtual RunStore* store() const = 0;
  virtual RunObserver* observer() const = 0;
  virtual const RunContext& context() const = 0;
  // Whether the task need not run after all: its inputs turned out not to have changed.
  virtual bool Skip(size_t task_idx) = 0;
  // The task is on record.
  virtual void OnDone(size_t task_idx) = 0;
  // To run the task here: its progress is that part of the stage.
  virtual RunContext ContextOf(size_t task_idx) const = 0;
  // Of tasks that are not done yet, so much of the planned CPU time is over.
  virtual void ReportProgress(double running_seconds) = 0;
  // For run_status.
  virtual void ShowJobs(const JobCounts& jobs) = 0;
};

// What a stage's tasks run on.
class Engine {
 public:
  virtual ~Engine() = default;
  // As the option names it.
  virtual std::string name() const = 0;
  // Runs the stage's tasks that are to run. Throws what a task throws, CancelledError, and
  // Error(kExternalTool) where the job system fails.
  virtual void RunStage(StageWork* work) = 0;
  // All tasks of the run are done: leaves nothing behind.
  virtual void Finish() {}
  // For the plan.
  virtual StageDivision Divide(const std::vector<Task>& tasks, const RunPlan& plan,
                               const PlannedStage& stage) const = 0;
};

// The driver's process, with all threads of the context.
std::unique_ptr<Engine> MakeLocalEngine();
// Of jobs.
struct JobThreads {
  int shared = 1;  // where a stage has many tasks
  int alone = 1;   // where it has a single one
};
// That a job's process takes beside its task.
struct ProcessBytes {
  size_t shared = 0, alone = 0;  // as JobThreads
};
// Slurm or command, for the run in the folder `root`. Throws Error(kExternalTool) if Slurm's
// programs are missing.
std::unique_ptr<Engine> MakeJobEngine(const std::filesystem::path& root,
                                      const EngineOptions& options, const DriverCommand& command,
                                      const JobThreads& threads, const ProcessBytes& process_bytes);
// What the largest of the engine's machines has, asked before the plan is made; nothing where that
// is unknown. Throws Error(kExternalTool) if Slurm does not answer.
std::optional<JobLimits> FindJobLimits(const EngineOptions& options);

}  // namespace lsmvs
