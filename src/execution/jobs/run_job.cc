#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "lsmvs/execution/file_table.h"
#include "lsmvs/execution/helpers/helper_leader.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/execution/jobs/job_files.h"
#include "lsmvs/execution/run_record.h"
#include "lsmvs/execution/run_store.h"
#include "lsmvs/execution/tasks/task_runner.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"
#include "lsmvs/util/host_name.h"
#include "lsmvs/util/periodic_thread.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kProgressInterval(2000);

// Keeps the progress of the task at hand, for the file that the driver looks at.
class ProgressFile : public ProgressSink {
 public:
  explicit ProgressFile(fs::path folder)
      : folder_(std::move(folder)), writer_(kProgressInterval, [this] { Write(); }) {}

  void Report(double fraction) override {
    const std::lock_guard lock(mutex_);
    progress_.fraction = std::max(progress_.fraction, fraction);
  }
  void Begin(size_t position) {
    {
      const std::lock_guard lock(mutex_);
      progress_ = {position, 0};
    }
    Write();
  }

 private:
  void Write() {
    JobProgress progress;
    {
      const std::lock_guard lock(mutex_);
      progress = progress_;
    }
    WriteProgress(folder_, progress);
  }

  const fs::path folder_;
  std::mutex mutex_;
  JobProgress progress_;
  PeriodicThread writer_;
};

class JobRunner {
 public:
  JobRunner(const fs::path& root, const fs::path& batch_folder, JobOrder order, size_t slice,
            const std::vector<Task>& tasks, const RunContext& context)
      : root_(root),
        slice_folder_(SliceFolder(batch_folder, slice)),
        order_(std::move(order)),
        files_(root),
        node_(HostName()),
        context_(context) {
    if (slice >= order_.slices.size()) {
      throw InputError(batch_folder.string(), "has no such job", "start the run again");
    }
    slice_ = order_.slices[slice];
    for (const Task& task : tasks) tasks_[task.name] = &task;
    std::error_code error;
    fs::create_directories(slice_folder_, error);
    if (error) throw FileSystemError(slice_folder_.string(), "create the folder", error.value());
  }

  void Run() {
    ProgressFile progress(slice_folder_);
    RunContext context = context_;
    context.set_progress(&progress);
    if (order_.num_helpers > 0) context.helpers = &leader_.emplace(LeaderPath(slice_folder_));
    for (size_t k = 0; k < slice_.size(); ++k) {
      const fs::path outcome = OutcomePath(slice_folder_, k);
      if (fs::exists(outcome)) continue;
      context.ThrowIfCancelled();
      progress.Begin(k);
      RunOne(slice_[k], outcome, context);
    }
  }

 private:
  const Task& Find(const OrderedTask& ordered) const {
    const auto found = tasks_.find(ordered.name);
    if (found != tasks_.end() && IdentityOf(*found->second, files_) == ordered.identity) {
      return *found->second;
    }
    throw InputError(ordered.name,
                     "is not the task that was ordered: the options, the photos or the program "
                     "have changed since the run was started",
                     "stop the run and start it again");
  }

  void RunOne(const OrderedTask& ordered, const fs::path& outcome_path, const RunContext& context) {
    TaskOutcome outcome;
    outcome.node = node_;
    try {
      const Task& task = Find(ordered);
      RunTask(task, ordered.inputs_hash, Site(ordered), context, [&](FinishedTask done) {
        if (leader_) {
          done.record.counts["items_by_helpers"] =
              static_cast<double>(leader_->num_items_by_helpers());
        }
        outcome.done = Keep(ordered.name, std::move(done));
        WriteOutcome(outcome_path, outcome);
      });
    } catch (const CancelledError&) {
      throw;
    } catch (const Error& error) {
      outcome.done.reset();
      outcome.code = error.code();
      outcome.error = error.what();
      WriteOutcome(outcome_path, outcome);
      throw;
    }
  }

  TaskSite Site(const OrderedTask& ordered) const {
    TaskSite site;
    site.root = root_;
    site.scratch_folder = order_.scratch_folder;
    site.resident_bytes = ordered.resident_bytes;
    site.process_bytes =
        order_.memory_bytes - std::min(order_.memory_bytes, context_.memory_budget_bytes);
    site.staged_path = [this](const fs::path& output) {
      return JobOutputPath(slice_folder_, files_.Key(output), JobOutput::kWriting);
    };
    site.check_added = [this](const fs::path& output) { CheckAdded(output); };
    return site;
  }

  void CheckAdded(const fs::path& output) const {
    if (order_.overwrite || !fs::exists(output)) return;
    RunRecord record = ReadRecordOf(root_);
    CheckReplaceable(output, &record.files);
  }

  // The results, out of reach of the next writer.
  PublishingRecord Keep(const std::string& name, FinishedTask done) const {
    PublishingRecord kept{name, std::move(done.record), {}};
    for (const fs::path& output : done.outputs) {
      const std::string key = files_.Key(output);
      const fs::path written = JobOutputPath(slice_folder_, key, JobOutput::kWriting);
      const fs::path path = JobOutputPath(slice_folder_, key, JobOutput::kDone);
      std::error_code error;
      fs::create_directories(path.parent_path(), error);
      fs::rename(written, path, error);
      if (error) throw FileSystemError(path.string(), "finish the file", error.value());
      kept.task.outputs.push_back(key);
      kept.files.push_back({StampOf(path), HashFile(path), name});
    }
    return kept;
  }

  const fs::path root_, slice_folder_;
  const JobOrder order_;
  const FileTable files_;
  const std::string node_;
  const RunContext& context_;
  std::vector<OrderedTask> slice_;
  std::optional<HelperLeader> leader_;
  std::map<std::string, const Task*> tasks_;
};

// A job that helps the first slice of its batch.
void RunHelper(const fs::path& root, const fs::path& batch_folder, const JobOrder& order,
               const std::vector<Task>& tasks, const RunContext& context) {
  const OrderedTask& ordered = order.slices.front().front();
  const FileTable files(root);
  const auto task = std::find_if(tasks.begin(), tasks.end(), [&](const Task& candidate) {
    return candidate.name == ordered.name && IdentityOf(candidate, files) == ordered.identity;
  });
  if (task == tasks.end() || !task->make_worker) return;
  const fs::path folder = SliceFolder(batch_folder, 0);
  const auto is_over = [&] { return !fs::exists(folder) || fs::exists(OutcomePath(folder, 0)); };
  if (is_over()) return;
  const std::unique_ptr<LoopWorker> worker = task->make_worker(context);
  HelpLeader(LeaderPath(folder), is_over, worker.get(), context);
}

}  // namespace

void RunJob(const fs::path& root, const JobNumber& job, const std::vector<Task>& tasks,
            const RunContext& context) {
  const fs::path batch_folder = JobsFolder(root) / job.batch;
  JobOrder order = ReadJobOrder(batch_folder);
  const bool helps =
      job.slice >= order.slices.size() && job.slice < order.slices.size() + order.num_helpers;
  if (helps) return RunHelper(root, batch_folder, order, tasks, context);
  JobRunner(root, batch_folder, std::move(order), job.slice, tasks, context).Run();
}

}  // namespace lsmvs
