#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/execution/job_order.h"
#include "lsmvs/execution/jobs/job_files.h"
#include "lsmvs/execution/jobs/job_system.h"

namespace lsmvs {

// A job whose tasks are not all accounted for.
struct LiveSlice {
  std::vector<size_t> task_idxs;   // as in the order
  std::vector<bool> is_collected;  // as task_idxs: done, or to be done by another job
  JobStatus status;
  bool was_asked_for = false;  // the job system has told `status`
  // When the job system first said that the job has ended.
  std::optional<std::chrono::steady_clock::time_point> over_since;

  // The first task that is not collected; the number of tasks if all are.
  size_t FirstOpen() const;
  bool is_open() const { return FirstOpen() < task_idxs.size(); }
};

// A batch of jobs that was submitted, by this driver or an earlier one.
struct LiveBatch {
  std::filesystem::path folder;
  JobOrder order;
  std::string handle;
  std::vector<LiveSlice> slices;  // as in the order

  size_t NumOpen() const;
  JobBatch ToJobBatch(const std::string& program, const std::filesystem::path& root) const;
};

// A new folder below the run's folder for jobs, with the order, and one folder a slice: jobs find
// theirs, and a driver that lists it sees new files at once on file systems that cache names.
std::filesystem::path MakeBatchFolder(const std::filesystem::path& root, const JobOrder& order);
void WriteHandle(const std::filesystem::path& batch_folder, const std::string& handle);
// Nothing if the batch was not submitted, or the driver was killed before it noted that.
std::optional<std::string> ReadHandle(const std::filesystem::path& batch_folder);
// The batch's jobs were cancelled, or somebody else cancelled one: nobody goes on with them.
void MarkAbandoned(const std::filesystem::path& batch_folder);
bool IsAbandoned(const std::filesystem::path& batch_folder);
// Folders of all batches, the oldest first.
std::vector<std::filesystem::path> FindBatchFolders(const std::filesystem::path& root);

}  // namespace lsmvs
