#pragma once

#include <cstddef>

#include "lsmvs/execution/jobs/job_failures.h"
#include "lsmvs/execution/jobs/stage_jobs.h"

namespace lsmvs {

// Looks after the jobs of a stage: takes what they have finished, notices those that ended before,
// and tells how far they are.
class JobWatch {
 public:
  explicit JobWatch(StageJobs* jobs) : jobs_(*jobs), failures_(jobs) {}

  // Looks at the files of all open jobs, and asks the job system for their states, less often the
  // longer nothing has happened. Throws what JobFailures throws.
  void Look();
  // Until the next look is due. Throws CancelledError.
  void Wait() const;

 private:
  void Poll();
  void Poll(LiveBatch* batch);
  void LookAt(LiveBatch* batch, size_t slice);
  void Collect(LiveBatch* batch, size_t slice);
  void Publish(size_t task_idx, const PublishingRecord& done,
               const std::filesystem::path& slice_folder);
  bool Close(const LiveBatch& batch) const;
  double RunningSeconds(const LiveBatch& batch, size_t slice) const;
  void NoteWaiting(const JobCounts& counts);

  StageJobs& jobs_;
  JobFailures failures_;
  StageJobs::Clock::time_point next_poll_, last_poll_;
  size_t num_without_answer_ = 0;
};

}  // namespace lsmvs
