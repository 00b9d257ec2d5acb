#pragma once

#include <cstddef>
#include <span>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/jobs/task_slices.h"

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
// Jobs that help a task which is a job of its own, where so many can run at once: none where the
// task would be over before they have begun, or works with a scratch file: they would have to hold
// all of its mesh in memory.
size_t NumHelpers(const Task& task, const PlannedTask& planned, int num_threads,
                  size_t jobs_at_once, const EngineOptions& options);
// Limit of time of a job [s]: four times what the plan says, times the factor, and ten minutes.
double JobTimeLimit(double planned_cpu_seconds, int num_threads, double factor);
// Lengths of the jobs of a stage whose tasks take so much CPU time in all: at most as long as the
// options say; the shortest a twentieth of what each of the jobs at once does, 5 to 60 s, so that
// starting them does not count and machines hardly wait for the last one.
SliceLengths LengthsOfJobs(double all_cpu_seconds, int num_threads, size_t jobs_at_once,
                           const EngineOptions& options);

}  // namespace lsmvs
