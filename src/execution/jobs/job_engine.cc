#include <algorithm>
#include <utility>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/jobs/job_submission.h"
#include "lsmvs/execution/jobs/job_watch.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

std::vector<size_t> TasksToRun(const RunPlan& plan, const PlannedStage& stage) {
  std::vector<size_t> to_run;
  for (size_t i = stage.begin; i < stage.end; ++i) {
    if (plan.tasks[i].state == TaskState::kRun) to_run.push_back(i);
  }
  return to_run;
}

// One stage on the job system.
class StageDriver {
 public:
  explicit StageDriver(StageJobs jobs)
      : jobs_(std::move(jobs)),
        tasks_(jobs_.work.tasks(), TasksToRun(jobs_.work.plan(), jobs_.work.stage())),
        submission_(&jobs_, &tasks_),
        watch_(&jobs_) {}

  void Run() {
    try {
      RunAll();
    } catch (const CancelledError&) {
      EndJobs(jobs_.NumOpen() > 0 && jobs_.work.observer()->KeepJobs(jobs_.NumOpen()));
      throw;
    } catch (...) {
      EndJobs(false);
      throw;
    }
  }

 private:
  void RunAll() {
    submission_.Adopt();
    jobs_.last_event = StageJobs::Clock::now();
    while (true) {
      submission_.Submit();
      if (TakeDone()) continue;
      if (jobs_.NumOpen() == 0 && tasks_.ready().empty() && jobs_.again.empty()) return;
      watch_.Look();
      if (!TakeDone() && !submission_.MaySubmitAgain() && jobs_.NumOpen() > 0) watch_.Wait();
    }
  }

  // Whether something was done, so that other tasks may be ready.
  bool TakeDone() {
    const std::set<size_t> done = std::exchange(jobs_.done, {});
    for (const size_t i : done) tasks_.OnDone(i);
    return !done.empty();
  }

  // Those that somebody wants to go on stay as they are.
  void EndJobs(bool keep) {
    if (keep) return;
    for (const LiveBatch& batch : jobs_.batches) {
      if (batch.NumOpen() == 0 && batch.order.num_helpers == 0) continue;
      jobs_.system.Cancel(batch.handle);
      MarkAbandoned(batch.folder);
    }
  }

  StageJobs jobs_;
  ReadyTasks tasks_;
  JobSubmission submission_;
  JobWatch watch_;
};

std::unique_ptr<JobSystem> MakeSystem(const EngineOptions& options) {
  return options.kind == EngineKind::kSlurm ? MakeSlurmJobs(options) : MakeCommandJobs(options);
}

class JobEngine : public Engine {
 public:
  JobEngine(const fs::path& root, const EngineOptions& options, const DriverCommand& command,
            const JobThreads& threads, const ProcessBytes& process_bytes)
      : root_(root),
        options_(options),
        command_(command),
        threads_(threads),
        process_bytes_(process_bytes),
        system_(MakeSystem(options)),
        limits_(system_->Limits()) {}

  std::string name() const override {
    return options_.kind == EngineKind::kSlurm ? "slurm" : "command";
  }

  void RunStage(StageWork* work) override {
    StageDriver({.root = fs::absolute(root_),
                 .options = options_,
                 .command = command_,
                 .process_bytes = BytesOfProcess(work->stage()),
                 .limits = limits_,
                 .num_threads = Threads(work->stage()),
                 .system = *system_,
                 .work = *work})
        .Run();
  }

  void Finish() override {
    std::error_code ignored;
    fs::remove_all(JobsFolder(root_), ignored);
  }

  StageDivision Divide(const std::vector<Task>& tasks, const RunPlan& plan,
                       const PlannedStage& stage) const override {
    const std::vector<size_t> to_run = TasksToRun(plan, stage);
    StageDivision division;
    division.num_threads = Threads(stage);
    for (const size_t i : to_run) {
      division.memory_bytes =
          std::max(division.memory_bytes,
                   JobMemoryBytes(tasks[i], plan.tasks[i], BytesOfProcess(stage), 1, limits_));
    }
    const size_t at_once = JobsAtOnce(options_, limits_, division.num_threads);
    for (const auto& round : RoundsOf(tasks, to_run)) {
      double seconds = 0;
      for (const size_t i : round) seconds += tasks[i].cost.cpu_seconds;
      const SliceLengths lengths = LengthsOfJobs(seconds, division.num_threads, at_once, options_);
      const size_t num_jobs = SliceTasks(tasks, round, lengths, seconds).size();
      division.num_jobs += num_jobs;
      division.jobs_at_once = std::max(division.jobs_at_once, std::min(num_jobs, at_once));
    }
    if (division.num_jobs == 1 && to_run.size() == 1) {
      const size_t i = to_run.front();
      division.num_helpers =
          NumHelpers(tasks[i], plan.tasks[i], division.num_threads, at_once, options_);
    }
    division.job_seconds = stage.cost.cpu_seconds / division.num_threads /
                           static_cast<double>(std::max<size_t>(1, division.num_jobs));
    return division;
  }

 private:
  static bool IsShared(const PlannedStage& stage) { return stage.end - stage.begin > 1; }
  int Threads(const PlannedStage& stage) const {
    return IsShared(stage) ? threads_.shared : threads_.alone;
  }
  size_t BytesOfProcess(const PlannedStage& stage) const {
    return IsShared(stage) ? process_bytes_.shared : process_bytes_.alone;
  }

  const fs::path root_;
  const EngineOptions options_;
  const DriverCommand command_;
  const JobThreads threads_;
  const ProcessBytes process_bytes_;
  const std::unique_ptr<JobSystem> system_;
  const std::optional<JobLimits> limits_;
};

}  // namespace

std::unique_ptr<Engine> MakeJobEngine(const fs::path& root, const EngineOptions& options,
                                      const DriverCommand& command, const JobThreads& threads,
                                      const ProcessBytes& process_bytes) {
  return std::make_unique<JobEngine>(root, options, command, threads, process_bytes);
}

std::optional<JobLimits> FindJobLimits(const EngineOptions& options) {
  if (options.kind == EngineKind::kLocal) return std::nullopt;
  return MakeSystem(options)->Limits();
}

}  // namespace lsmvs
