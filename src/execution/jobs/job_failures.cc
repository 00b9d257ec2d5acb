#include "lsmvs/execution/jobs/job_failures.h"

#include <fmt/format.h>

#include <fstream>

#include "lsmvs/util/child_process.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr double kRaise = 2;
constexpr int kMaxLostNodes = 20;

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

// Where a job system ends a job for want of memory without saying so by its state, the last lines
// of the log tell: of Slurm's daemon, of PBS, or of the program.
bool LogTellsOfMemory(const std::filesystem::path& log_path) {
  std::ifstream log(log_path);
  const std::string lines = LastLines(log);
  for (const char* text :
       {"memory limit", "oom-kill", "oom_kill", "mem exceeded", "out of memory", "out-of-memory"}) {
    if (lines.find(text) != std::string::npos) return true;
  }
  return false;
}

// The kernel ends the process that takes too much.
bool MayBeMemory(const JobStatus& status) {
  return status.state == JobState::kOutOfMemory ||
         (status.state == JobState::kFailed &&
          status.reason.find("RaisedSignal:9") != std::string::npos);
}

std::string Raised(const JobStatus& status, const EngineOptions& options) {
  if (MayBeMemory(status)) return ", with more memory";
  const bool may_raise = options.kind != EngineKind::kSlurm || options.time.empty();
  return status.state == JobState::kOutOfTime && may_raise ? ", with more time" : "";
}

std::string Advice(const JobStatus& status, const EngineOptions& options) {
  const bool is_given = options.kind == EngineKind::kSlurm && !options.time.empty();
  return status.state == JobState::kOutOfTime && is_given ? "; give a longer --Slurm.time" : "";
}

}  // namespace

bool IsOver(JobState state) { return state != JobState::kWaiting && state != JobState::kRunning; }

void JobFailures::OnTask(size_t task_idx, const TaskOutcome& outcome, const LiveBatch& batch) {
  if (outcome.code == ExitCode::kBadInput || outcome.code == ExitCode::kUsage ||
      outcome.code == ExitCode::kOverwrite) {
    throw Error(outcome.code, outcome.error);
  }
  jobs_.failed_batches.insert(batch.folder.string());
  TaskHistory& history = jobs_.history[task_idx];
  ++history.num_failures;
  if (outcome.code == ExitCode::kMemory) RaiseMemory(task_idx);
  const std::string& name = jobs_.work.tasks()[task_idx].name;
  if (history.num_failures >= jobs_.options.max_attempts) {
    throw Error(outcome.code, fmt::format("{}: failed {} times, the last time on {}: {}", name,
                                          history.num_failures, outcome.node, outcome.error));
  }
  jobs_.Note(fmt::format("{}: failed on {}: {}; it is tried again (start {} of {})", name,
                         outcome.node, outcome.error, history.num_failures + 1,
                         jobs_.options.max_attempts));
  jobs_.again.insert(task_idx);
}

void JobFailures::OnJob(LiveBatch* batch, size_t slice_idx) {
  LiveSlice& slice = batch->slices[slice_idx];
  jobs_.last_event = StageJobs::Clock::now();
  jobs_.failed_batches.insert(batch->folder.string());
  const std::string job =
      fmt::format("job {}_{} of {}", batch->handle, slice_idx, jobs_.system.name());
  if ((slice.status.state == JobState::kFailed || slice.status.state == JobState::kCancelled) &&
      LogTellsOfMemory(LogPath(batch->folder, slice_idx))) {
    slice.status.state = JobState::kOutOfMemory;
  }
  if (slice.status.state == JobState::kCancelled) {
    throw Error(ExitCode::kCancelled,
                fmt::format("{} was cancelled by somebody else{}; finished work is kept: ask why, "
                            "and start the same command again to go on",
                            job, slice.status.node.empty() ? "" : " on " + slice.status.node));
  }
  Blame(slice.task_idxs[slice.FirstOpen()], *batch, slice_idx, job);
  size_t num_left = 0;
  for (size_t k = 0; k < slice.task_idxs.size(); ++k) {
    if (slice.is_collected[k]) continue;
    slice.is_collected[k] = true;
    const size_t i = slice.task_idxs[k];
    if (MayBeMemory(slice.status)) RaiseMemory(i);
    if (slice.status.state == JobState::kOutOfTime) jobs_.history[i].time_factor *= kRaise;
    jobs_.again.insert(i);
    ++num_left;
  }
  jobs_.Note(fmt::format("{} {}; {} of its {} tasks are submitted again{}", job,
                         Describe(slice.status), num_left, slice.task_idxs.size(),
                         Raised(slice.status, jobs_.options)));
}

// The task at which the job ended.
void JobFailures::Blame(size_t task_idx, const LiveBatch& batch, size_t slice_idx,
                        const std::string& job) {
  const LiveSlice& slice = batch.slices[slice_idx];
  TaskHistory& history = jobs_.history[task_idx];
  const bool is_node = slice.status.state == JobState::kNodeLost;
  const int count = is_node ? ++history.num_lost_nodes : ++history.num_failures;
  if (count < (is_node ? kMaxLostNodes : jobs_.options.max_attempts)) return;
  const std::filesystem::path log_path = LogPath(batch.folder, slice_idx);
  std::ifstream log(log_path);
  const std::string lines = LastLines(log);
  throw Error(ExitCode::kExternalTool,
              fmt::format("{}: failed {} times, the last time because {} {}{}; see {}{}",
                          jobs_.work.tasks()[task_idx].name, count, job, Describe(slice.status),
                          lines.empty() ? "" : ": " + lines, log_path.string(),
                          Advice(slice.status, jobs_.options)));
}

void JobFailures::RaiseMemory(size_t task_idx) { jobs_.history[task_idx].memory_factor *= kRaise; }

}  // namespace lsmvs
