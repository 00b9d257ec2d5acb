#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lsmvs/execution/run_record.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

// The files through which a job reports; see engine.h.

// What became of a task in a job.
struct TaskOutcome {
  std::optional<PublishingRecord> done;
  // Of a task that failed: what it threw.
  ExitCode code = ExitCode::kOk;
  std::string error;
  std::string node;
};

std::filesystem::path SliceFolder(const std::filesystem::path& batch_folder, size_t slice);
std::filesystem::path LogPath(const std::filesystem::path& batch_folder, size_t slice);
std::filesystem::path OutcomePath(const std::filesystem::path& slice_folder, size_t position);
// Where the job of a slice says how its helpers reach it (helper_leader.h).
std::filesystem::path LeaderPath(const std::filesystem::path& slice_folder);
// Where a job writes an output with this key of the file table, and where it lies once its task is
// done.
enum class JobOutput { kWriting, kDone };
std::filesystem::path JobOutputPath(const std::filesystem::path& slice_folder,
                                    const std::string& key, JobOutput state);

void WriteOutcome(const std::filesystem::path& path, const TaskOutcome& outcome);
// Nothing if it is not there (yet) or is not whole.
std::optional<TaskOutcome> ReadOutcome(const std::filesystem::path& path);

// How far a job is: the share of the task at this position.
struct JobProgress {
  size_t position = 0;
  double fraction = 0;
};
void WriteProgress(const std::filesystem::path& slice_folder, const JobProgress& progress);
JobProgress ReadProgress(const std::filesystem::path& slice_folder);

}  // namespace lsmvs
