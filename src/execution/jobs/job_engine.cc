#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <deque>
#include <fstream>
#include <map>
#include <set>
#include <thread>
#include <utility>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/jobs/job_needs.h"
#include "lsmvs/execution/jobs/live_batch.h"
#include "lsmvs/execution/jobs/task_slices.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/util/child_process.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

// Slurm's default MaxArraySize is 1001.
constexpr size_t kMaxBatch = 1000;
constexpr double kRaise = 2;
constexpr int kMaxLostNodes = 20;
// Of a job that has ended, its files may still be on their way.
constexpr seconds kGraceOfEnded(3), kGraceOfUnknown(30);
constexpr milliseconds kShortestPoll(300), kLongestPoll(15000), kCancelPoll(50);
constexpr seconds kWaitBeforeNote(10);
constexpr int kPollsWithoutAnswer = 5;

bool IsOver(JobState state) { return state != JobState::kWaiting && state != JobState::kRunning; }

std::string Describe(const JobStatus& status) {
  const std::string where = status.node.empty() ? "" : " on " + status.node;
  const std::string reason =
      status.reason.empty() || status.reason == "None" ? "" : " (" + status.reason + ")";
  switch (status.state) {
    case JobState::kOutOfMemory:
      return "took more memory than it had asked for" + where + reason;
    case JobState::kOutOfTime:
      return "reached its time limit" + where + reason;
    case JobState::kNodeLost:
      return "was lost with its node" + where + reason;
    case JobState::kCancelled:
      return "was cancelled" + where + reason;
    case JobState::kUnknown:
      return "has vanished from the job system";
    case JobState::kSucceeded:
      return "ended without a result" + where;
    default:
      return "failed" + where + reason;
  }
}

// The kernel ends the process that takes too much.
bool MayBeMemory(const JobStatus& status) {
  return status.state == JobState::kOutOfMemory ||
         (status.state == JobState::kFailed &&
          status.reason.find("RaisedSignal:9") != std::string::npos);
}

std::string UniqueName(const fs::path& root) {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  const std::string text =
      fmt::format("{} {} {} {}", host, ::getpid(), now, fs::absolute(root).string());
  return "lsmvs-" + Hasher().Update(text).HexDigest().substr(0, 12);
}

std::vector<std::vector<size_t>> RoundsToRun(const std::vector<Task>& tasks, const RunPlan& plan,
                                             const PlannedStage& stage) {
  std::vector<size_t> to_run;
  for (size_t i = stage.begin; i < stage.end; ++i) {
    if (plan.tasks[i].state == TaskState::kRun) to_run.push_back(i);
  }
  return RoundsOf(tasks, to_run);
}

// Jobs of tasks that can run at the same time, of the length that the options ask for.
std::vector<std::vector<size_t>> JobsOf(const std::vector<Task>& tasks,
                                        const std::vector<size_t>& task_idxs, int num_threads,
                                        const EngineOptions& options) {
  double all_seconds = 0;
  for (const size_t i : task_idxs) all_seconds += tasks[i].cost.cpu_seconds;
  return SliceTasks(tasks, task_idxs, SliceSeconds(all_seconds, num_threads, options));
}

// One stage on the job system.
class StageDriver {
 public:
  StageDriver(const fs::path& root, const EngineOptions& options, const DriverCommand& command,
              size_t process_bytes, const std::optional<JobLimits>& limits, int num_threads,
              JobSystem* system, StageWork* work)
      : root_(fs::absolute(root)),
        options_(options),
        command_(command),
        process_bytes_(process_bytes),
        limits_(limits),
        num_threads_(num_threads),
        system_(*system),
        work_(*work) {}

  void Run() {
    try {
      for (const auto& round : RoundsToRun(work_.tasks(), work_.plan(), work_.stage())) {
        RunRound(round);
      }
    } catch (const CancelledError&) {
      EndJobs(NumOpen() > 0 && work_.observer()->KeepJobs(NumOpen()));
      throw;
    } catch (...) {
      EndJobs(false);
      throw;
    }
    EndJobs(false);
  }

 private:
  // Those that somebody wants to go on stay as they are.
  void EndJobs(bool keep) {
    if (keep) return;
    for (const LiveBatch& batch : batches_) {
      if (batch.NumOpen() == 0) continue;
      system_.Cancel(batch.handle);
      MarkAbandoned(batch.folder);
    }
  }

  void RunRound(const std::vector<size_t>& round) {
    todo_.clear();
    for (const size_t i : round) {
      work_.context().ThrowIfCancelled();
      if (!work_.Skip(i)) todo_.insert(i);
    }
    Adopt();
    last_event_ = Clock::now();
    while (true) {
      Submit();
      if (NumOpen() == 0) return;
      Watch();
      if (NumOpen() > 0 || !todo_.empty()) Wait();
    }
  }

  size_t NumOpen() const {
    size_t count = 0;
    for (const LiveBatch& batch : batches_) count += batch.NumOpen();
    return count;
  }

  // --- Jobs of an earlier driver

  // Takes over the jobs that do what is to be done; cancels the others, and removes their folders.
  void Adopt() {
    std::map<std::string, size_t> task_of_name;
    for (const size_t i : todo_) task_of_name[work_.tasks()[i].name] = i;
    size_t num_adopted = 0;
    for (const fs::path& folder : FindBatchFolders(root_)) {
      if (std::any_of(batches_.begin(), batches_.end(),
                      [&](const LiveBatch& batch) { return batch.folder == folder; })) {
        continue;
      }
      std::optional<LiveBatch> batch = Reopen(folder, task_of_name);
      if (batch && batch->NumOpen() > 0) {
        num_adopted += batch->NumOpen();
        batches_.push_back(*std::move(batch));
      } else {
        if (batch && !batch->handle.empty()) system_.Cancel(batch->handle);
        std::error_code ignored;
        fs::remove_all(folder, ignored);
      }
    }
    if (num_adopted > 0) {
      Note(fmt::format("goes on with {} jobs of an earlier start of this run", num_adopted));
    }
  }

  std::optional<LiveBatch> Reopen(const fs::path& folder,
                                  const std::map<std::string, size_t>& task_of_name) {
    if (IsAbandoned(folder)) return std::nullopt;
    LiveBatch batch;
    batch.folder = folder;
    try {
      batch.order = ReadJobOrder(folder);
    } catch (const InputError&) {
      return std::nullopt;  // killed before it was written
    }
    if (batch.order.engine != system_.name()) return std::nullopt;
    batch.slices.resize(batch.order.slices.size());
    const JobBatch description = batch.ToJobBatch(command_.program, root_);
    batch.handle = ReadHandle(folder).value_or("");
    if (batch.handle.empty()) batch.handle = system_.Find(description).value_or("");
    if (batch.handle.empty()) return std::nullopt;
    for (size_t s = 0; s < batch.slices.size(); ++s) {
      for (const OrderedTask& ordered : batch.order.slices[s]) {
        const auto found = task_of_name.find(ordered.name);
        const bool is_wanted = found != task_of_name.end() && todo_.contains(found->second) &&
                               IsSame(ordered, found->second);
        if (is_wanted) todo_.erase(found->second);
        batch.slices[s].task_idxs.push_back(is_wanted ? found->second : 0);
        batch.slices[s].is_collected.push_back(!is_wanted);
      }
    }
    return batch;
  }

  bool IsSame(const OrderedTask& ordered, size_t i) {
    FileTable& files = work_.store()->files();
    const Task& task = work_.tasks()[i];
    return ordered.identity == IdentityOf(task, files) &&
           ordered.inputs_hash == HashInputs(task, &files);
  }

  // --- Submission

  void Submit() {
    // Tasks of equal needs share batches.
    std::map<std::pair<double, double>, std::vector<size_t>> groups;
    for (const size_t i : todo_) {
      const TaskHistory& history = history_[i];
      groups[{history.memory_factor, history.time_factor}].push_back(i);
    }
    todo_.clear();
    for (const auto& [factors, task_idxs] : groups) {
      const auto slices = JobsOf(work_.tasks(), task_idxs, num_threads_, options_);
      for (size_t begin = 0; begin < slices.size(); begin += kMaxBatch) {
        const size_t end = std::min(slices.size(), begin + kMaxBatch);
        SubmitBatch({slices.begin() + static_cast<std::ptrdiff_t>(begin),
                     slices.begin() + static_cast<std::ptrdiff_t>(end)},
                    factors.first, factors.second);
      }
    }
  }

  void SubmitBatch(const std::vector<std::vector<size_t>>& slices, double memory_factor,
                   double time_factor) {
    work_.context().ThrowIfCancelled();
    LiveBatch batch;
    JobOrder& order = batch.order;
    order.engine = system_.name();
    order.batch_name = UniqueName(root_);
    order.command_name = command_.name;
    order.arguments = command_.arguments;
    order.working_folder = fs::current_path();
    order.scratch_folder = fs::absolute(work_.plan().scratch_folder);
    order.overwrite = work_.plan().overwrite;
    order.num_threads = num_threads_;
    for (const auto& slice : slices) AddSlice(slice, memory_factor, time_factor, &batch);
    batch.folder = MakeBatchFolder(root_, order);
    batch.handle = system_.Submit(batch.ToJobBatch(command_.program, root_));
    WriteHandle(batch.folder, batch.handle);
    batches_.push_back(std::move(batch));
    last_event_ = submitted_ = Clock::now();
    has_noted_waiting_ = false;
  }

  void AddSlice(const std::vector<size_t>& task_idxs, double memory_factor, double time_factor,
                LiveBatch* batch) {
    FileTable& files = work_.store()->files();
    JobOrder& order = batch->order;
    std::vector<OrderedTask> ordered;
    double cpu_seconds = 0;
    for (const size_t i : task_idxs) {
      const Task& task = work_.tasks()[i];
      const PlannedTask& planned = work_.plan().tasks[i];
      ordered.push_back(
          {task.name, IdentityOf(task, files), HashInputs(task, &files), planned.resident_bytes});
      cpu_seconds += task.cost.cpu_seconds;
      order.memory_bytes =
          std::max(order.memory_bytes,
                   JobMemoryBytes(task, planned, process_bytes_, memory_factor, limits_));
    }
    order.seconds = std::max(order.seconds, JobTimeLimit(cpu_seconds, num_threads_, time_factor));
    order.slices.push_back(std::move(ordered));
    LiveSlice slice;
    slice.task_idxs = task_idxs;
    slice.is_collected.assign(task_idxs.size(), false);
    batch->slices.push_back(std::move(slice));
  }

  // --- Watching

  void Wait() {
    const auto since = std::chrono::duration_cast<milliseconds>(Clock::now() - last_event_);
    const auto end = Clock::now() + std::clamp(since / 10, kShortestPoll, kLongestPoll);
    while (Clock::now() < end) {
      work_.context().ThrowIfCancelled();
      std::this_thread::sleep_for(kCancelPoll);
    }
  }

  void Watch() {
    double running_seconds = 0;
    JobCounts counts;
    std::set<std::string> nodes;
    for (LiveBatch& batch : batches_) {
      if (batch.NumOpen() == 0) continue;
      Poll(&batch);
      for (size_t s = 0; s < batch.slices.size(); ++s) {
        LiveSlice& slice = batch.slices[s];
        if (!slice.is_open()) continue;
        Look(&batch, s);
        if (!slice.is_open()) continue;
        if (slice.status.state == JobState::kWaiting) {
          if (counts.waiting++ == 0) counts.reason = slice.status.reason;
        } else {
          ++counts.running;
          if (!slice.status.node.empty()) nodes.insert(slice.status.node);
          running_seconds += RunningSeconds(batch, s);
        }
      }
    }
    std::erase_if(batches_, [this](const LiveBatch& batch) { return Close(batch); });
    counts.nodes = fmt::format("{}", fmt::join(nodes, " "));
    NoteWaiting(counts);
    work_.ShowJobs(counts);
    work_.ReportProgress(running_seconds);
  }

  // Removes what is left of a batch once all its tasks are accounted for; logs of jobs that failed
  // stay until the run has ended.
  bool Close(const LiveBatch& batch) {
    if (batch.NumOpen() > 0) return false;
    if (!failed_batches_.contains(batch.folder.string())) {
      std::error_code ignored;
      fs::remove_all(batch.folder, ignored);
    }
    return true;
  }

  void Poll(LiveBatch* batch) {
    const auto statuses = system_.Poll(batch->ToJobBatch(command_.program, root_), batch->handle);
    if (!statuses) {
      if (++num_without_answer_ == kPollsWithoutAnswer) {
        Note(system_.name() + " does not answer; the run waits for it");
      }
      return;
    }
    num_without_answer_ = 0;
    for (size_t s = 0; s < batch->slices.size(); ++s) batch->slices[s].status = (*statuses)[s];
  }

  double RunningSeconds(const LiveBatch& batch, size_t s) const {
    const JobProgress progress = ReadProgress(SliceFolder(batch.folder, s));
    const LiveSlice& slice = batch.slices[s];
    if (progress.position >= slice.task_idxs.size()) return 0;
    if (slice.is_collected[progress.position]) return 0;
    return progress.fraction * work_.tasks()[slice.task_idxs[progress.position]].cost.cpu_seconds;
  }

  // Takes what a job has finished; once it has ended, what it has not finished is to be done anew.
  void Look(LiveBatch* batch, size_t s) {
    LiveSlice& slice = batch->slices[s];
    const bool was_over = IsOver(slice.status.state);
    Collect(batch, s);
    if (!slice.is_open()) return;
    if (!was_over) {
      slice.over_since.reset();
      return;
    }
    if (!slice.over_since) slice.over_since = Clock::now();
    const seconds grace =
        slice.status.state == JobState::kUnknown ? kGraceOfUnknown : kGraceOfEnded;
    if (Clock::now() - *slice.over_since >= grace) GiveUp(batch, s);
  }

  void Collect(LiveBatch* batch, size_t s) {
    LiveSlice& slice = batch->slices[s];
    const fs::path folder = SliceFolder(batch->folder, s);
    std::error_code ignored;
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      names.insert(entry.path().filename().string());
    }
    for (size_t k = slice.FirstOpen(); k < slice.task_idxs.size(); ++k) {
      if (slice.is_collected[k]) continue;
      const fs::path path = OutcomePath(folder, k);
      if (!names.contains(path.filename().string())) return;
      const std::optional<TaskOutcome> outcome = ReadOutcome(path);
      if (!outcome) return;
      slice.is_collected[k] = true;
      last_event_ = Clock::now();
      if (outcome->done) {
        Publish(slice.task_idxs[k], *outcome->done, folder);
      } else {
        OnFailure(slice.task_idxs[k], *outcome, *batch);
      }
    }
  }

  void Publish(size_t i, const PublishingRecord& done, const fs::path& slice_folder) {
    RunStore& store = *work_.store();
    const Task& task = work_.tasks()[i];
    std::vector<fs::path> outputs, staged;
    std::vector<std::string> hashes;
    bool is_whole = done.task.inputs_hash == HashInputs(task, &store.files());
    for (size_t f = 0; f < done.files.size(); ++f) {
      const std::string& key = done.task.outputs[f];
      outputs.push_back(store.files().PathOfKey(key));
      staged.push_back(JobOutputPath(slice_folder, key, JobOutput::kDone));
      hashes.push_back(done.files[f].hash);
      std::error_code error;
      is_whole = is_whole && fs::file_size(staged.back(), error) == done.files[f].stamp.size;
    }
    if (!is_whole) {
      Note(task.name + ": its input changed while it ran; it is run again");
      todo_.insert(i);
      return;
    }
    store.Publish(task.name, outputs, staged, hashes, done.task);
    for (const fs::path& path : staged) {
      std::error_code ignored;
      fs::remove(path.parent_path(), ignored);  // fails, as it should, while others are in it
    }
    work_.OnDone(i);
  }

  // --- Failures

  // A task that says why it failed.
  void OnFailure(size_t i, const TaskOutcome& outcome, const LiveBatch& batch) {
    if (outcome.code == ExitCode::kBadInput || outcome.code == ExitCode::kUsage ||
        outcome.code == ExitCode::kOverwrite) {
      throw Error(outcome.code, outcome.error);
    }
    failed_batches_.insert(batch.folder.string());
    TaskHistory& history = history_[i];
    ++history.num_failures;
    if (outcome.code == ExitCode::kMemory) RaiseMemory(i);
    if (history.num_failures >= options_.max_attempts) {
      throw Error(outcome.code,
                  fmt::format("{}: failed {} times, the last time on {}: {}", work_.tasks()[i].name,
                              history.num_failures, outcome.node, outcome.error));
    }
    Note(fmt::format("{}: failed on {}: {}; it is tried again (start {} of {})",
                     work_.tasks()[i].name, outcome.node, outcome.error, history.num_failures + 1,
                     options_.max_attempts));
    todo_.insert(i);
  }

  // A job that has ended before its tasks.
  void GiveUp(LiveBatch* batch, size_t s) {
    LiveSlice& slice = batch->slices[s];
    last_event_ = Clock::now();
    failed_batches_.insert(batch->folder.string());
    const std::string job = fmt::format("job {}_{} of {}", batch->handle, s, system_.name());
    if (slice.status.state == JobState::kCancelled) {
      throw Error(
          ExitCode::kCancelled,
          fmt::format("{} was cancelled by somebody else{}; finished work is kept: ask why, "
                      "and start the same command again to go on",
                      job, slice.status.node.empty() ? "" : " on " + slice.status.node));
    }
    Blame(slice.task_idxs[slice.FirstOpen()], *batch, s, job);
    size_t num_left = 0;
    for (size_t k = 0; k < slice.task_idxs.size(); ++k) {
      if (slice.is_collected[k]) continue;
      slice.is_collected[k] = true;
      const size_t i = slice.task_idxs[k];
      if (MayBeMemory(slice.status)) RaiseMemory(i);
      if (slice.status.state == JobState::kOutOfTime) history_[i].time_factor *= kRaise;
      todo_.insert(i);
      ++num_left;
    }
    Note(fmt::format("{} {}; {} of its {} tasks are submitted again{}", job, Describe(slice.status),
                     num_left, slice.task_idxs.size(), Raised(slice)));
  }

  static std::string Raised(const LiveSlice& slice) {
    if (MayBeMemory(slice.status)) return ", with more memory";
    return slice.status.state == JobState::kOutOfTime ? ", with more time" : "";
  }

  // The task at which the job ended.
  void Blame(size_t i, const LiveBatch& batch, size_t s, const std::string& job) {
    const LiveSlice& slice = batch.slices[s];
    TaskHistory& history = history_[i];
    const bool is_node = slice.status.state == JobState::kNodeLost;
    const int count = is_node ? ++history.num_lost_nodes : ++history.num_failures;
    if (count < (is_node ? kMaxLostNodes : options_.max_attempts)) return;
    const fs::path log_path = LogPath(batch.folder, s);
    std::ifstream log(log_path);
    const std::string lines = LastLines(log);
    throw Error(ExitCode::kExternalTool,
                fmt::format("{}: failed {} times, the last time because {} {}{}; see {}",
                            work_.tasks()[i].name, count, job, Describe(slice.status),
                            lines.empty() ? "" : ": " + lines, log_path.string()));
  }

  void RaiseMemory(size_t i) { history_[i].memory_factor *= kRaise; }

  // --- Messages

  void Note(const std::string& note) { work_.observer()->OnNote(note); }

  void NoteWaiting(const JobCounts& counts) {
    if (counts.waiting == 0 || counts.running > 0 || has_noted_waiting_) return;
    if (Clock::now() - submitted_ < kWaitBeforeNote) return;
    has_noted_waiting_ = true;
    const bool may_never_start = NeedsAttention(counts.reason);
    Note(fmt::format("{} jobs wait in the queue of {}{}{}", counts.waiting, system_.name(),
                     counts.reason.empty() ? "" : ": " + counts.reason,
                     may_never_start ? "; they may never start: check the --Slurm options, and "
                                       "squeue, with which jobs can be looked at"
                                     : ""));
  }

  // Reasons that do not pass by themselves.
  static bool NeedsAttention(const std::string& reason) {
    for (const char* text :
         {"PartitionConfig", "BadConstraints", "Assoc", "QOS", "Invalid", "PartitionNodeLimit",
          "PartitionTimeLimit", "PartitionDown", "ReqNodeNotAvail", "JobHeld", "launch failed"}) {
      if (reason.find(text) != std::string::npos) return true;
    }
    return false;
  }

  const fs::path root_;
  const EngineOptions& options_;
  const DriverCommand& command_;
  const size_t process_bytes_;
  const std::optional<JobLimits> limits_;
  const int num_threads_;
  JobSystem& system_;
  StageWork& work_;

  std::set<size_t> todo_;  // tasks of the round that no job has
  std::deque<LiveBatch> batches_;
  std::map<size_t, TaskHistory> history_;
  std::set<std::string> failed_batches_;
  Clock::time_point last_event_, submitted_;
  bool has_noted_waiting_ = false;
  int num_without_answer_ = 0;
};

std::unique_ptr<JobSystem> MakeSystem(const EngineOptions& options) {
  return options.kind == EngineKind::kSlurm ? MakeSlurmJobs(options) : MakeCommandJobs(options);
}

class JobEngine : public Engine {
 public:
  JobEngine(const fs::path& root, const EngineOptions& options, const DriverCommand& command,
            const JobThreads& threads, size_t process_bytes)
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
    StageDriver(root_, options_, command_, process_bytes_, limits_, Threads(work->stage()),
                system_.get(), work)
        .Run();
  }

  void Finish() override {
    std::error_code ignored;
    fs::remove_all(JobsFolder(root_), ignored);
  }

  StageDivision Divide(const std::vector<Task>& tasks, const RunPlan& plan,
                       const PlannedStage& stage) const override {
    StageDivision division;
    division.num_threads = Threads(stage);
    for (const auto& round : RoundsToRun(tasks, plan, stage)) {
      for (const size_t i : round) {
        division.memory_bytes =
            std::max(division.memory_bytes,
                     JobMemoryBytes(tasks[i], plan.tasks[i], process_bytes_, 1, limits_));
      }
      const size_t num_jobs = JobsOf(tasks, round, division.num_threads, options_).size();
      division.num_jobs += num_jobs;
      division.jobs_at_once = std::max(division.jobs_at_once,
                                       std::min(num_jobs, static_cast<size_t>(options_.max_jobs)));
    }
    division.job_seconds = stage.cost.cpu_seconds / division.num_threads /
                           static_cast<double>(std::max<size_t>(1, division.num_jobs));
    return division;
  }

 private:
  int Threads(const PlannedStage& stage) const {
    return stage.end - stage.begin > 1 ? threads_.shared : threads_.alone;
  }

  const fs::path root_;
  const EngineOptions options_;
  const DriverCommand command_;
  const JobThreads threads_;
  const size_t process_bytes_;
  const std::unique_ptr<JobSystem> system_;
  const std::optional<JobLimits> limits_;
};

}  // namespace

std::unique_ptr<Engine> MakeJobEngine(const fs::path& root, const EngineOptions& options,
                                      const DriverCommand& command, const JobThreads& threads,
                                      size_t process_bytes) {
  return std::make_unique<JobEngine>(root, options, command, threads, process_bytes);
}

std::optional<JobLimits> FindJobLimits(const EngineOptions& options) {
  if (options.kind == EngineKind::kLocal) return std::nullopt;
  return MakeSystem(options)->Limits();
}

}  // namespace lsmvs
