#include "lsmvs/execution/jobs/job_needs.h"

#include <algorithm>

#include "lsmvs/execution/job_order.h"

namespace lsmvs {

namespace {
constexpr double kMoreMemory = 1.2;
constexpr double kMoreBytes = 256e6;
constexpr double kProgramShare = 0.95;
constexpr double kMoreTime = 4;
constexpr double kMoreSeconds = 600;
constexpr double kSlicesPerJob = 4;
constexpr double kLeastSliceSeconds = 60;
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

double JobTimeLimit(double planned_cpu_seconds, int num_threads, double factor) {
  return (kMoreTime * planned_cpu_seconds / num_threads + kMoreSeconds) * factor;
}

double SliceSeconds(double all_cpu_seconds, int num_threads, const EngineOptions& options) {
  const double longest = 60 * options.job_minutes * num_threads;
  const double shortest = std::min(longest, kLeastSliceSeconds * num_threads);
  return std::clamp(all_cpu_seconds / (kSlicesPerJob * options.max_jobs), shortest, longest);
}

}  // namespace lsmvs
