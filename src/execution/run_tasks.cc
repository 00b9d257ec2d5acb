#include "lsmvs/execution/run_tasks.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <mutex>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/run_status.h"
#include "lsmvs/execution/tasks/task_runner.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/host_name.h"

namespace lsmvs {

namespace {

using Clock = std::chrono::steady_clock;

// Removes what a temporary task of ours made, unless somebody changed it or it was made to be kept.
void RemoveOutputs(const Task& task, RunStore* store) {
  const auto record = store->tasks().find(task.name);
  if (record == store->tasks().end() || !record->second.temporary) return;
  for (const std::filesystem::path& output : task.outputs) {
    std::error_code ignored;
    if (store->files().MadeBy(output) == task.name) std::filesystem::remove(output, ignored);
  }
}

double Weight(const Task& task) { return std::max(task.cost.cpu_seconds, 1e-6); }

// Leaves the status of a run for others to read, and takes it away when the run has ended.
class StatusFile {
 public:
  StatusFile(const std::filesystem::path& root, const std::string& engine) : root_(root) {
    status_.engine = engine;
    status_.host = HostName();
    status_.process_id = ::getpid();
  }
  ~StatusFile() { RemoveRunStatus(root_); }
  StatusFile(const StatusFile&) = delete;
  StatusFile& operator=(const StatusFile&) = delete;

  void Begin(const std::string& stage, double fraction, size_t num_tasks, size_t num_done) {
    const std::lock_guard lock(mutex_);
    status_.stage = stage;
    status_.began = std::time(nullptr);
    status_.fraction = status_.fraction_before = fraction;
    status_.num_tasks = num_tasks;
    status_.num_done = num_done;
    status_.jobs = {};
    Write();
  }
  void SetFraction(double fraction) {
    const std::lock_guard lock(mutex_);
    status_.fraction = std::max(status_.fraction, fraction);
    WriteSometimes();
  }
  void CountDone() {
    const std::lock_guard lock(mutex_);
    ++status_.num_done;
  }
  void SetJobs(const JobCounts& jobs) {
    const std::lock_guard lock(mutex_);
    const bool has_changed =
        jobs.waiting != status_.jobs.waiting || jobs.running != status_.jobs.running;
    status_.jobs = jobs;
    if (has_changed) {
      Write();
    } else {
      WriteSometimes();
    }
  }

 private:
  void WriteSometimes() {
    constexpr std::chrono::seconds kInterval(2);
    if (Clock::now() - written_ >= kInterval) Write();
  }
  void Write() {
    status_.updated = std::time(nullptr);
    written_ = Clock::now();
    WriteRunStatus(root_, status_);
  }

  const std::filesystem::path root_;
  std::mutex mutex_;
  RunStatus status_;
  Clock::time_point written_;
};

class RunningStage : public StageWork, public ProgressSink {
 public:
  RunningStage(const std::vector<Task>& tasks, const RunPlan& plan, const PlannedStage& stage,
               RunStore* store, RunObserver* observer, StatusFile* status,
               const RunContext& context)
      : tasks_(tasks),
        plan_(plan),
        stage_(stage),
        store_(*store),
        observer_(observer),
        status_(*status),
        shown_(context.progress()),
        context_(context),
        begin_(Clock::now()),
        is_done_(stage.end - stage.begin, false),
        next_drop_(stage.begin) {
    context_.set_progress(this);
    double to_run = 0;
    for (size_t i = stage.begin; i < stage.end; ++i) {
      total_ += Weight(tasks[i]);
      if (plan.tasks[i].state == TaskState::kRun) to_run += Weight(tasks[i]);
    }
    done_ = total_ - to_run;
    const size_t num_tasks = stage.end - stage.begin;
    status_.Begin(stage.name, FractionDone(), num_tasks, num_tasks - stage.num_run);
  }

  const std::vector<Task>& tasks() const override { return tasks_; }
  const RunPlan& plan() const override { return plan_; }
  const PlannedStage& stage() const override { return stage_; }
  RunStore* store() const override { return &store_; }
  RunObserver* observer() const override { return observer_; }
  const RunContext& context() const override { return context_; }

  double FractionDone() const { return done_ / total_; }

  RunContext ContextOf(size_t i) const override {
    return context_.Part(FractionDone(), std::min(1.0, (done_ + Weight(tasks_[i])) / total_));
  }

  bool Skip(size_t i) override {
    if (!ReasonToRun(tasks_[i], &store_).empty()) return false;
    ++num_skipped_;
    CountDone(i);
    return true;
  }

  void OnDone(size_t i) override {
    ++num_ran_;
    peak_bytes_ = std::max<uint64_t>(peak_bytes_, store_.tasks().at(tasks_[i].name).peak_bytes);
    CountDone(i);
  }

  void ReportProgress(double running_seconds) override {
    context_.Report(std::min(1.0, (done_ + running_seconds) / total_));
  }

  void ShowJobs(const JobCounts& jobs) override { status_.SetJobs(jobs); }

  // Of the context: on its way to whoever shows it.
  void Report(double fraction) override {
    status_.SetFraction(fraction);
    if (shown_ != nullptr) shown_->Report(fraction);
  }

  StageSummary Summary() const {
    StageSummary summary;
    summary.name = stage_.name;
    summary.num_ran = num_ran_;
    summary.num_up_to_date = stage_.num_up_to_date + num_skipped_;
    summary.num_foreign = stage_.num_foreign;
    summary.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    summary.peak_bytes = peak_bytes_;
    for (size_t i = stage_.begin; i < stage_.end; ++i) {
      const auto found = store_.tasks().find(tasks_[i].name);
      if (found == store_.tasks().end()) continue;
      for (const auto& [name, count] : found->second.counts) summary.counts[name] += count;
    }
    return summary;
  }

 private:
  void CountDone(size_t i) {
    done_ += Weight(tasks_[i]);
    status_.CountDone();
    is_done_[i - stage_.begin] = true;
    Drop();
    ReportProgress(0);
  }

  // Tasks may end in any order; those that read what is dropped after a task come before it.
  void Drop() {
    for (; next_drop_ < stage_.end; ++next_drop_) {
      const bool runs = plan_.tasks[next_drop_].state == TaskState::kRun;
      if (runs && !is_done_[next_drop_ - stage_.begin]) return;
      if (!runs) continue;
      for (const size_t dropped : plan_.drops[next_drop_]) RemoveOutputs(tasks_[dropped], &store_);
    }
  }

  const std::vector<Task>& tasks_;
  const RunPlan& plan_;
  const PlannedStage& stage_;
  RunStore& store_;
  RunObserver* const observer_;
  StatusFile& status_;
  ProgressSink* const shown_;
  RunContext context_;
  const Clock::time_point begin_;
  std::vector<bool> is_done_;  // of the stage's tasks
  size_t next_drop_;
  double total_ = 0, done_ = 0;
  size_t num_ran_ = 0, num_skipped_ = 0;
  uint64_t peak_bytes_ = 0;
};

}  // namespace

std::vector<StageSummary> RunTasks(const std::vector<Task>& tasks, const RunPlan& plan,
                                   RunStore* store, RunObserver* observer,
                                   const RunContext& context, Engine* engine) {
  LSMVS_CHECK_EQ(tasks.size(), plan.tasks.size());
  const std::unique_ptr<Engine> local = MakeLocalEngine();
  if (engine == nullptr) engine = local.get();
  std::vector<StageSummary> summaries;
  for (const size_t leftover : plan.leftovers) RemoveOutputs(tasks[leftover], store);
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (plan.tasks[i].state == TaskState::kRun) continue;
    RemoveCheckpoints(tasks[i], store->root(), plan.scratch_folder);
  }
  StatusFile status(store->root(), engine->name());
  for (const PlannedStage& stage : plan.stages) {
    if (stage.num_run == 0) continue;
    RunningStage work(tasks, plan, stage, store, observer, &status, context);
    observer->OnStageBegin(stage, work.FractionDone());
    engine->RunStage(&work);
    summaries.push_back(work.Summary());
    observer->OnStageEnd(summaries.back());
  }
  store->Save();
  engine->Finish();
  return summaries;
}

}  // namespace lsmvs
