#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/execution/run_plan.h"
#include "lsmvs/execution/task.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// A task of a job. What it depends on is part of the order, so that a job that starts late, or with
// another version of the program, does not give another result under the same name.
struct OrderedTask {
  std::string name;
  std::string identity;       // IdentityOf the task
  std::string inputs_hash;    // HashInputs of the task
  size_t resident_bytes = 0;  // as in PlannedTask
};

// What a batch's jobs do: <root>/lsmvs/jobs/<batch>/order.json.
struct JobOrder {
  std::string engine;  // job system that it was submitted to
  std::string batch_name;
  std::string command_name;            // as in DriverCommand
  std::vector<std::string> arguments;  // of that command
  std::filesystem::path working_folder;
  std::filesystem::path scratch_folder;
  bool overwrite = false;
  int num_threads = 1;
  size_t memory_bytes = 0;                       // that a job's process may take
  double seconds = 0;                            // limit that was asked for
  std::vector<std::vector<OrderedTask>> slices;  // one a job
  // Further jobs, numbered after the slices: they help the first one (shared_loop.h).
  size_t num_helpers = 0;
};

// Hash of what the task's results depend on, but for the contents of its inputs. `root`: of the
// run.
std::string IdentityOf(const Task& task, const FileTable& files);

// What the program may take of the memory that its job has.
size_t ProgramMemoryBytes(size_t job_bytes);

std::filesystem::path JobsFolder(const std::filesystem::path& root);
void WriteJobOrder(const std::filesystem::path& batch_folder, const JobOrder& order);
// Throws InputError.
JobOrder ReadJobOrder(const std::filesystem::path& batch_folder);

// A job as its command names it: "12.3" is the fourth of the batch in the folder 12.
struct JobNumber {
  std::string batch;
  size_t slice = 0;
};
// Throws UsageError.
JobNumber ParseJobNumber(const std::string& text);

// Runs a job of the run in `root`, or helps one: its tasks, those of `tasks` that the order names.
// What earlier starts of the same job have finished is not done again. A task that fails leaves a
// record of it, for the driver, and ends the job with what it threw. Throws InputError if the
// order's tasks are not to be found or are not the same.
void RunJob(const std::filesystem::path& root, const JobNumber& job, const std::vector<Task>& tasks,
            const RunContext& context);

}  // namespace lsmvs
