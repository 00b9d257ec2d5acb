#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/execution/engine.h"

namespace lsmvs {

// Jobs of equal needs, numbered from 0.
struct JobBatch {
  std::string name;              // unique among all runs; what the job system shows
  std::filesystem::path folder;  // exists; logs go to <folder>/<number>.log
  size_t num_jobs = 0;
  // Of job i: these words, the last one with i appended.
  std::vector<std::string> command;
  int num_threads = 1;
  size_t memory_bytes = 0;
  double seconds = 0;  // limit
};

enum class JobState {
  kWaiting,
  kRunning,
  kSucceeded,  // its process ended with code 0
  kFailed,
  kOutOfMemory,
  kOutOfTime,
  kNodeLost,
  kCancelled,  // by somebody
  kUnknown,    // the job system does not know it (any more)
};

struct JobStatus {
  JobState state = JobState::kUnknown;
  std::string node;    // where it runs or ran
  std::string reason;  // why it waits, or what the job system says of its end
};

// A batch system. Batches are known by a handle, a line of text that another process can use, too.
class JobSystem {
 public:
  virtual ~JobSystem() = default;
  virtual std::string name() const = 0;
  // Throws Error(kExternalTool) with what the system says.
  virtual std::string Submit(const JobBatch& batch) = 0;
  // Handle of a batch that a driver submitted that was killed before it could note it.
  virtual std::optional<std::string> Find(const JobBatch& batch) = 0;
  // Status of each job; nothing where the system does not answer at present.
  virtual std::optional<std::vector<JobStatus>> Poll(const JobBatch& batch,
                                                     const std::string& handle) = 0;
  // Ends the jobs of the batch that wait or run.
  virtual void Cancel(const std::string& handle) = 0;
  virtual std::optional<JobLimits> Limits() const { return std::nullopt; }
  // Whether batches that are submitted wait for machines with those that run, so that several may
  // be under way.
  virtual bool HasQueue() const = 0;
};

std::unique_ptr<JobSystem> MakeSlurmJobs(const EngineOptions& options);
std::unique_ptr<JobSystem> MakeCommandJobs(const EngineOptions& options);

// The words as one line of sh.
std::string ShellLine(const std::vector<std::string>& words);
// The command of job `number`.
std::vector<std::string> CommandOf(const JobBatch& batch, size_t number);

}  // namespace lsmvs
