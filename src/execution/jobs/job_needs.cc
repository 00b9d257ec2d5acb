#include "lsmvs/execution/jobs/job_needs.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/execution/job_order.h"

namespace lsmvs {

namespace {
constexpr double kMoreMemory = 1.2;
constexpr double kMoreBytes = 256e6;
constexpr double kProgramShare = 0.95;
constexpr double kMoreTime = 4;
constexpr double kMoreSeconds = 600;
// The shortest jobs, as a part of what one machine does, and in seconds.
constexpr double kShortestShare = 0.05, kLeastShortest = 5, kMostShortest = 60;
}  // namespace

size_t JobMemoryBytes(const Task& task, const PlannedTask& planned, size_t process_bytes,
                      double factor, const std::optional<JobLimits>& limits) {
  const size_t task_bytes =
      planned.resident_bytes > 0 ? planned.resident_bytes : task.cost.peak_bytes;
  const auto needed = static_cast<double>(process_bytes + task_bytes);
  const auto bytes = static_cast<size_t>((kMoreMemory * needed + kMoreBytes) * factor);
  if (!limits || limits->memory_bytes == 0) return bytes;
  return std::min(bytes, limits->memory_bytes);
}

size_t ProgramMemoryBytes(size_t job_bytes) {
  return static_cast<size_t>(kProgramShare * static_cast<double>(job_bytes));
}

size_t NumHelpers(const Task& task, const PlannedTask& planned, int num_threads,
                  size_t jobs_at_once, const EngineOptions& options) {
  if (planned.resident_bytes > 0) return 0;
  // Of each helper, so much work that its start does not count.
  const double least_seconds = std::min(kLeastShortest, 60 * options.job_minutes);
  const double seconds = task.cost.cpu_seconds / num_threads;
  const double most = least_seconds > 0 ? seconds / least_seconds : seconds > 0 ? 1e6 : 0;
  const auto worth = static_cast<size_t>(std::max(0.0, most - 1));
  return std::min({worth, task.max_helpers, jobs_at_once - 1});
}

double JobTimeLimit(double planned_cpu_seconds, int num_threads, double factor) {
  return (kMoreTime * planned_cpu_seconds / num_threads + kMoreSeconds) * factor;
}

SliceLengths LengthsOfJobs(double all_cpu_seconds, int num_threads, size_t jobs_at_once,
                           const EngineOptions& options) {
  const double share = all_cpu_seconds / num_threads / static_cast<double>(jobs_at_once);
  const double wanted = std::clamp(kShortestShare * share, kLeastShortest, kMostShortest);
  // As many on each machine.
  const double count = std::max(1.0, std::round(share / wanted));
  return {.longest = 60 * options.job_minutes * num_threads,
          .shortest = share / count * num_threads,
          .jobs_at_once = jobs_at_once};
}

}  // namespace lsmvs
