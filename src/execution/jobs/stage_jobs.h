#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/jobs/job_needs.h"
#include "lsmvs/execution/jobs/job_system.h"
#include "lsmvs/execution/jobs/live_batch.h"

namespace lsmvs {

// What the parts of the driver of one stage share: what jobs are made with, and what is known of
// them.
struct StageJobs {
  using Clock = std::chrono::steady_clock;

  std::filesystem::path root;  // absolute
  const EngineOptions& options;
  const DriverCommand& command;
  size_t process_bytes;
  std::optional<JobLimits> limits;
  int num_threads;  // of a job
  JobSystem& system;
  StageWork& work;

  std::deque<LiveBatch> batches = {};  // that have open jobs
  std::map<size_t, TaskHistory> history = {};
  std::set<size_t> again = {};  // tasks to be submitted again
  std::set<size_t> done = {};   // tasks whose results came in since the set was emptied last
  // Folders of batches with a job that failed: their logs stay until the run has ended.
  std::set<std::string> failed_batches = {};
  Clock::time_point last_event = {}, last_submission = {};
  bool has_noted_waiting = false;

  // Jobs that are not accounted for.
  size_t NumOpen() const;
  // Jobs that can run at the same time, about.
  size_t JobsAtOnce() const;
  void Note(const std::string& note) const;
};

// How many jobs of so many threads can run at the same time, about.
size_t JobsAtOnce(const EngineOptions& options, const std::optional<JobLimits>& limits,
                  int num_threads);

}  // namespace lsmvs
