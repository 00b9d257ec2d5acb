#pragma once

#include <string>

#include "lsmvs/execution/jobs/job_files.h"
#include "lsmvs/execution/jobs/stage_jobs.h"

namespace lsmvs {

// Whether the job has ended, or nobody knows of it.
bool IsOver(JobState state);

// Decides what becomes of work that failed: its tasks are put among those to be submitted again,
// with more memory or time where these were too short, or the run ends.
class JobFailures {
 public:
  explicit JobFailures(StageJobs* jobs) : jobs_(*jobs) {}

  // A task that says why it failed. Throws what it threw if that would not change, or at the last
  // attempt.
  void OnTask(size_t task_idx, const TaskOutcome& outcome, const LiveBatch& batch);
  // A job that has ended before its tasks. Throws Error(kCancelled) if somebody else cancelled it,
  // Error(kExternalTool) at the last attempt.
  void OnJob(LiveBatch* batch, size_t slice);

 private:
  void Blame(size_t task_idx, const LiveBatch& batch, size_t slice, const std::string& job);
  void RaiseMemory(size_t task_idx);

  StageJobs& jobs_;
};

}  // namespace lsmvs
