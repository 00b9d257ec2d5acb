#pragma once

#include <cstddef>
#include <span>

#include "lsmvs/execution/engine.h"

namespace lsmvs {

// What became of a task's starts, and what its next job asks for because of that.
struct TaskHistory {
  int num_failures = 0;  // that may be the task's own
  int num_lost_nodes = 0;
  double memory_factor = 1;  // on what the plan says
  double time_factor = 1;
};

// Memory that a job of the task asks for: what the plan says with a fifth and 256 MB on top, times
// the factor, and no more than a machine has.
size_t JobMemoryBytes(const Task& task, const PlannedTask& planned, size_t process_bytes,
                      double factor, const std::optional<JobLimits>& limits);
// Limit of time of a job [s]: four times what the plan says, times the factor, and ten minutes.
double JobTimeLimit(double planned_cpu_seconds, int num_threads, double factor);
// CPU time of the tasks of a slice [s]: short enough that `max_jobs` jobs at once have several
// slices each, but not below a minute, and no longer than the options say.
double SliceSeconds(double all_cpu_seconds, int num_threads, const EngineOptions& options);

}  // namespace lsmvs
