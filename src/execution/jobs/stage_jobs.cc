#include "lsmvs/execution/jobs/stage_jobs.h"

#include <algorithm>

#include "lsmvs/execution/run_tasks.h"

namespace lsmvs {

size_t StageJobs::NumOpen() const {
  size_t count = 0;
  for (const LiveBatch& batch : batches) count += batch.NumOpen();
  return count;
}

size_t StageJobs::JobsAtOnce() const { return lsmvs::JobsAtOnce(options, limits, num_threads); }

void StageJobs::Note(const std::string& note) const { work.observer()->OnNote(note); }

size_t JobsAtOnce(const EngineOptions& options, const std::optional<JobLimits>& limits,
                  int num_threads) {
  if (options.kind == EngineKind::kCommand) return static_cast<size_t>(options.jobs_at_once);
  const int places = limits ? limits->num_threads_in_all / num_threads : options.max_jobs;
  return static_cast<size_t>(std::clamp(places, 1, options.max_jobs));
}

}  // namespace lsmvs
