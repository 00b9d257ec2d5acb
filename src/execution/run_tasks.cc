#include "lsmvs/execution/run_tasks.h"

#include <fmt/chrono.h>
#include <glog/logging.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/util/scratch_memory.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double CpuSeconds() {
  rusage usage = {};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string Now() {
  const std::time_t now = std::time(nullptr);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

// Removes what a task has staged, unless it was published.
class StagingGuard {
 public:
  StagingGuard(const Task& task, const RunStore& store) : outputs_(task.outputs), store_(store) {
    store_.PrepareStaging(outputs_);
  }
  ~StagingGuard() { store_.DropStaging(outputs_); }
  StagingGuard(const StagingGuard&) = delete;
  StagingGuard& operator=(const StagingGuard&) = delete;

  // Where to write it.
  std::filesystem::path Add(const std::filesystem::path& output) {
    outputs_.push_back(output);
    store_.PrepareStaging({&outputs_.back(), 1});
    return store_.StagedPath(output);
  }
  const std::vector<std::filesystem::path>& outputs() const { return outputs_; }

 private:
  std::vector<std::filesystem::path> outputs_;
  const RunStore& store_;
};

// The folders with the checkpoints of a task of this run store in the scratch folder: their names
// begin alike, and end with the hash of what the result depends on.
class TaskCheckpoints {
 public:
  TaskCheckpoints(const Task& task, const TaskRecord& record, const RunPlan& plan,
                  const RunStore& store)
      : is_on_(task.checkpoint_bytes > 0), scratch_folder_(plan.scratch_folder) {
    Hasher place, content;
    place.Update(fs::absolute(store.root()).lexically_normal().string()).Update(task.name);
    content.Update(record.version).Update(record.options).Update(record.inputs_hash);
    prefix_ = "lsmvs-steps-" + place.HexDigest().substr(0, 16) + "-";
    folder_ = scratch_folder_ / (prefix_ + content.HexDigest());
  }

  // Empty if the task has none.
  fs::path folder() const { return is_on_ ? folder_ : fs::path(); }

  // Of other inputs, options or versions.
  void RemoveOthers() const {
    Remove([&](const fs::path& path) { return path != folder_; });
  }
  void RemoveAll() const {
    Remove([](const fs::path&) { return true; });
  }

 private:
  template <class IsToGo>
  void Remove(const IsToGo& is_to_go) const {
    if (!is_on_) return;
    std::error_code ignored;
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(scratch_folder_, ignored)) {
      const bool is_ours = entry.path().filename().string().starts_with(prefix_);
      if (is_ours && is_to_go(entry.path())) found.push_back(entry.path());
    }
    for (const fs::path& path : found) fs::remove_all(path, ignored);
  }

  const bool is_on_;
  const fs::path scratch_folder_;
  std::string prefix_;
  fs::path folder_;
};

// With a scratch file, and no more than `resident_bytes` in memory; what the file was used for is
// put among the counts.
TaskCounts RunWithScratch(const Task& task, size_t resident_bytes, const RunPlan& plan,
                          const TaskRun& run) {
  const uint64_t read = ScratchMemory::BytesRead(), written = ScratchMemory::BytesWritten();
  const ScratchMemory scratch({plan.scratch_folder, plan.process_bytes + resident_bytes});
  RunContext context = run.context;
  context.memory_budget_bytes = resident_bytes;
  TaskCounts counts = task.run({context, run.outputs, run.add_output, run.checkpoint_folder});
  counts["scratch_bytes"] = static_cast<double>(ScratchMemory::PeakBytes());
  counts["scratch_bytes_read"] = static_cast<double>(ScratchMemory::BytesRead() - read);
  counts["scratch_bytes_written"] = static_cast<double>(ScratchMemory::BytesWritten() - written);
  return counts;
}

// As planned; a task that turns out to need more than there is gets a scratch file all the same.
// `run` has the checkpoint folder for the case that there is a scratch file.
TaskCounts RunWithin(const Task& task, const PlannedTask& planned, const RunPlan& plan,
                     const TaskRun& run) {
  const bool can = task.least_bytes > 0 && ScratchMemory::IsAvailable();
  if (can && planned.resident_bytes > 0) {
    return RunWithScratch(task, planned.resident_bytes, plan, run);
  }
  try {
    // What is there of an earlier run is used all the same.
    const bool goes_on = fs::exists(run.checkpoint_folder);
    return task.run(
        {run.context, run.outputs, run.add_output, goes_on ? run.checkpoint_folder : fs::path()});
  } catch (const MemoryError& error) {
    if (!can) throw;
    LOG(WARNING) << error.what() << "; works with a scratch file in "
                 << plan.scratch_folder.string();
  }
  const size_t resident_bytes = std::max(task.least_bytes, run.context.memory_budget_bytes);
  return RunWithScratch(task, resident_bytes, plan, run);
}

void RunTask(const Task& task, const PlannedTask& planned, const RunPlan& plan, RunStore* store,
             const RunContext& context) {
  TaskRecord record;
  record.stage = task.stage;
  record.version = task.version;
  record.options = task.options;
  record.inputs_hash = HashInputs(task, &store->files());
  record.num_threads = context.num_threads();
  record.temporary = task.temporary;
  std::vector<std::filesystem::path> staged;
  for (const auto& output : task.outputs) staged.push_back(store->StagedPath(output));
  StagingGuard guard(task, *store);
  const auto add_output = [&](const std::filesystem::path& output) {
    if (!plan.overwrite) CheckReplaceable(output, store);
    return guard.Add(output);
  };
  const PeakMemoryWatch memory;
  const Clock::time_point begin = Clock::now();
  const double cpu_begin = CpuSeconds();
  const TaskCheckpoints checkpoints(task, record, plan, *store);
  checkpoints.RemoveOthers();
  try {
    record.counts =
        RunWithin(task, planned, plan, {context, staged, add_output, checkpoints.folder()});
  } catch (const InputError&) {
    checkpoints.RemoveAll();  // the next start would end the same way
    throw;
  }
  record.seconds = SecondsSince(begin);
  record.cpu_seconds = CpuSeconds() - cpu_begin;
  record.peak_bytes = memory.PeakBytes();
  ReturnFreedMemory();
  record.finished = Now();
  store->Publish(task.name, guard.outputs(), std::move(record));
  checkpoints.RemoveAll();
}

// Removes what a temporary task of ours made, unless somebody changed it or it was made to be kept.
void RemoveOutputs(const Task& task, RunStore* store) {
  const auto record = store->tasks().find(task.name);
  if (record == store->tasks().end() || !record->second.temporary) return;
  for (const std::filesystem::path& output : task.outputs) {
    std::error_code ignored;
    if (store->files().MadeBy(output) == task.name) std::filesystem::remove(output, ignored);
  }
}

// Of a task that need not run: a run that was killed between its last two steps has left them.
void RemoveCheckpoints(const Task& task, const RunPlan& plan, const RunStore& store) {
  TaskCheckpoints(task, TaskRecord(), plan, store).RemoveAll();
}

double Weight(const Task& task) { return std::max(task.cost.cpu_seconds, 1e-6); }

class StageRunner {
 public:
  StageRunner(const std::vector<Task>& tasks, const RunPlan& plan, const PlannedStage& stage,
              RunStore* store, const RunContext& context)
      : tasks_(tasks), plan_(plan), stage_(stage), store_(*store), context_(context) {
    for (size_t i = stage.begin; i < stage.end; ++i) total_ += Weight(tasks[i]);
  }

  double FractionDone() const {
    double to_run = 0;
    for (size_t i = stage_.begin; i < stage_.end; ++i) {
      if (Runs(i)) to_run += Weight(tasks_[i]);
    }
    return 1 - to_run / total_;
  }

  StageSummary Run() {
    StageSummary summary;
    summary.name = stage_.name;
    summary.num_up_to_date = stage_.num_up_to_date;
    summary.num_foreign = stage_.num_foreign;
    const Clock::time_point begin = Clock::now();
    double done = FractionDone();
    for (size_t i = stage_.begin; i < stage_.end; ++i) {
      if (!Runs(i)) continue;
      const double next = std::min(1.0, done + Weight(tasks_[i]) / total_);
      RunOne(i, context_.Part(done, next), &summary);
      for (const size_t dropped : plan_.drops[i]) RemoveOutputs(tasks_[dropped], &store_);
      done = next;
    }
    summary.seconds = SecondsSince(begin);
    AddCounts(&summary);
    return summary;
  }

 private:
  bool Runs(size_t i) const { return plan_.tasks[i].state == TaskState::kRun; }

  void RunOne(size_t i, const RunContext& part, StageSummary* summary) {
    const Task& task = tasks_[i];
    part.ThrowIfCancelled();
    if (ReasonToRun(task, &store_).empty()) {
      ++summary->num_up_to_date;
    } else {
      RunTask(task, plan_.tasks[i], plan_, &store_, part);
      ++summary->num_ran;
      summary->peak_bytes =
          std::max<uint64_t>(summary->peak_bytes, store_.tasks().at(task.name).peak_bytes);
    }
    part.Report(1.0);
  }

  void AddCounts(StageSummary* summary) const {
    for (size_t i = stage_.begin; i < stage_.end; ++i) {
      const auto found = store_.tasks().find(tasks_[i].name);
      if (found == store_.tasks().end()) continue;
      for (const auto& [name, count] : found->second.counts) summary->counts[name] += count;
    }
  }

  const std::vector<Task>& tasks_;
  const RunPlan& plan_;
  const PlannedStage& stage_;
  RunStore& store_;
  const RunContext& context_;
  double total_ = 0;
};

}  // namespace

std::vector<StageSummary> RunTasks(const std::vector<Task>& tasks, const RunPlan& plan,
                                   RunStore* store, RunObserver* observer,
                                   const RunContext& context) {
  LSMVS_CHECK_EQ(tasks.size(), plan.tasks.size());
  std::vector<StageSummary> summaries;
  for (const size_t leftover : plan.leftovers) RemoveOutputs(tasks[leftover], store);
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (plan.tasks[i].state != TaskState::kRun) RemoveCheckpoints(tasks[i], plan, *store);
  }
  for (const PlannedStage& stage : plan.stages) {
    if (stage.num_run == 0) continue;
    StageRunner runner(tasks, plan, stage, store, context);
    observer->OnStageBegin(stage, runner.FractionDone());
    summaries.push_back(runner.Run());
    observer->OnStageEnd(summaries.back());
  }
  store->Save();
  return summaries;
}

}  // namespace lsmvs
