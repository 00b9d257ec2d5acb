#include "lsmvs/execution/jobs/job_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "lsmvs/execution/run_tasks.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::seconds;

// Of a job that has ended, its files may still be on their way.
constexpr seconds kGraceOfEnded(3), kGraceOfUnknown(30);
// The job system is asked at most so often: it serves others, too. Files are looked at more often,
// so that what waits for a result does not wait for long after it.
constexpr milliseconds kShortestPoll(300), kLongestPoll(15000);
constexpr milliseconds kShortestLook(100), kLongestLook(2000);
constexpr int kPollShare = 10, kLookShare = 100;  // of the time since something happened
constexpr milliseconds kCancelPoll(50);
constexpr seconds kWaitBeforeNote(10);
constexpr size_t kPollsWithoutAnswer = 5;

// Reasons to wait that do not pass by themselves.
bool NeedsAttention(const std::string& reason) {
  for (const char* text :
       {"PartitionConfig", "BadConstraints", "Assoc", "QOS", "Invalid", "PartitionNodeLimit",
        "PartitionTimeLimit", "PartitionDown", "ReqNodeNotAvail", "JobHeld", "launch failed"}) {
    if (reason.find(text) != std::string::npos) return true;
  }
  return false;
}

std::set<std::string> NamesIn(const fs::path& folder) {
  std::error_code ignored;
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

}  // namespace

void JobWatch::Wait() const {
  const auto now = StageJobs::Clock::now();
  const auto since = std::chrono::duration_cast<milliseconds>(now - jobs_.last_event);
  const auto end = now + std::clamp(since / kLookShare, kShortestLook, kLongestLook);
  while (StageJobs::Clock::now() < end) {
    jobs_.work.context().ThrowIfCancelled();
    std::this_thread::sleep_for(kCancelPoll);
  }
}

void JobWatch::Look() {
  Poll();
  double running_seconds = 0;
  JobCounts counts;
  std::set<std::string> nodes;
  for (LiveBatch& batch : jobs_.batches) {
    for (size_t s = 0; s < batch.slices.size(); ++s) {
      LiveSlice& slice = batch.slices[s];
      if (slice.is_open()) LookAt(&batch, s);
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
  std::erase_if(jobs_.batches, [this](const LiveBatch& batch) { return Close(batch); });
  counts.nodes = fmt::format("{}", fmt::join(nodes, " "));
  NoteWaiting(counts);
  jobs_.work.ShowJobs(counts);
  jobs_.work.ReportProgress(running_seconds);
}

void JobWatch::Poll() {
  const auto now = StageJobs::Clock::now();
  // Of a new batch nothing is known yet.
  const bool has_new = jobs_.last_submission > last_poll_;
  if (now < next_poll_ && !has_new) return;
  last_poll_ = now;
  for (LiveBatch& batch : jobs_.batches) Poll(&batch);
  const auto since = std::chrono::duration_cast<milliseconds>(now - jobs_.last_event);
  next_poll_ = now + std::clamp(since / kPollShare, kShortestPoll, kLongestPoll);
}

void JobWatch::Poll(LiveBatch* batch) {
  const auto statuses =
      jobs_.system.Poll(batch->ToJobBatch(jobs_.command.program, jobs_.root), batch->handle);
  if (!statuses) {
    if (++num_without_answer_ == kPollsWithoutAnswer) {
      jobs_.Note(jobs_.system.name() + " does not answer; the run waits for it");
    }
    return;
  }
  num_without_answer_ = 0;
  for (size_t s = 0; s < batch->slices.size(); ++s) {
    batch->slices[s].status = (*statuses)[s];
    batch->slices[s].was_asked_for = true;
  }
}

// Takes what a job has finished; once it has ended, what it has not finished is to be done anew.
void JobWatch::LookAt(LiveBatch* batch, size_t s) {
  LiveSlice& slice = batch->slices[s];
  const bool was_over = slice.was_asked_for && IsOver(slice.status.state);
  // A job that was waiting may have begun since, and even be done.
  Collect(batch, s);
  if (!slice.is_open()) return;
  if (!was_over) {
    slice.over_since.reset();
    return;
  }
  const auto now = StageJobs::Clock::now();
  if (!slice.over_since) slice.over_since = now;
  const seconds grace = slice.status.state == JobState::kUnknown ? kGraceOfUnknown : kGraceOfEnded;
  if (now - *slice.over_since >= grace) failures_.OnJob(batch, s);
}

void JobWatch::Collect(LiveBatch* batch, size_t s) {
  LiveSlice& slice = batch->slices[s];
  const fs::path folder = SliceFolder(batch->folder, s);
  const std::set<std::string> names = NamesIn(folder);
  for (size_t k = slice.FirstOpen(); k < slice.task_idxs.size(); ++k) {
    if (slice.is_collected[k]) continue;
    const fs::path path = OutcomePath(folder, k);
    if (!names.contains(path.filename().string())) return;
    const std::optional<TaskOutcome> outcome = ReadOutcome(path);
    if (!outcome) return;
    slice.is_collected[k] = true;
    jobs_.last_event = StageJobs::Clock::now();
    if (outcome->done) {
      Publish(slice.task_idxs[k], *outcome->done, folder);
    } else {
      failures_.OnTask(slice.task_idxs[k], *outcome, *batch);
    }
  }
}

void JobWatch::Publish(size_t i, const PublishingRecord& done, const fs::path& slice_folder) {
  RunStore& store = *jobs_.work.store();
  const Task& task = jobs_.work.tasks()[i];
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
    jobs_.Note(task.name + ": its input changed while it ran; it is run again");
    jobs_.again.insert(i);
    return;
  }
  store.Publish(task.name, outputs, staged, hashes, done.task);
  for (const fs::path& path : staged) {
    std::error_code ignored;
    fs::remove(path.parent_path(), ignored);  // fails, as it should, while others are in it
  }
  jobs_.done.insert(i);
  jobs_.work.OnDone(i);
}

// Removes what is left of a batch once all its tasks are accounted for.
bool JobWatch::Close(const LiveBatch& batch) const {
  if (batch.NumOpen() > 0) return false;
  // Helpers end by themselves, but for those that still wait in the queue.
  if (batch.order.num_helpers > 0) jobs_.system.Cancel(batch.handle);
  if (!jobs_.failed_batches.contains(batch.folder.string())) {
    std::error_code ignored;
    fs::remove_all(batch.folder, ignored);
  }
  return true;
}

double JobWatch::RunningSeconds(const LiveBatch& batch, size_t s) const {
  const JobProgress progress = ReadProgress(SliceFolder(batch.folder, s));
  const LiveSlice& slice = batch.slices[s];
  if (progress.position >= slice.task_idxs.size()) return 0;
  if (slice.is_collected[progress.position]) return 0;
  return progress.fraction *
         jobs_.work.tasks()[slice.task_idxs[progress.position]].cost.cpu_seconds;
}

void JobWatch::NoteWaiting(const JobCounts& counts) {
  if (counts.waiting == 0 || counts.running > 0 || jobs_.has_noted_waiting) return;
  if (StageJobs::Clock::now() - jobs_.last_submission < kWaitBeforeNote) return;
  jobs_.has_noted_waiting = true;
  const bool may_never_start = NeedsAttention(counts.reason);
  jobs_.Note(fmt::format("{} jobs wait in the queue of {}{}{}", counts.waiting, jobs_.system.name(),
                         counts.reason.empty() ? "" : ": " + counts.reason,
                         may_never_start ? "; they may never start: check the --Slurm options, "
                                           "and squeue, with which jobs can be looked at"
                                         : ""));
}

}  // namespace lsmvs
