#include "lsmvs/execution/tasks/task_runner.h"

#include <fmt/chrono.h>
#include <glog/logging.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <system_error>

#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/util/scratch_memory.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double CpuSeconds() {
  rusage usage = {};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string Now() {
  const std::time_t now = std::time(nullptr);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

// Makes room for what a task writes, and removes what is left of it in the end.
class StagedOutputs {
 public:
  StagedOutputs(const Task& task, const TaskSite& site) : site_(site) {
    for (const fs::path& output : task.outputs) Add(output);
  }
  ~StagedOutputs() {
    std::error_code ignored;
    for (const fs::path& output : outputs_) {
      const fs::path staged = site_.staged_path(output);
      fs::remove(staged, ignored);
      fs::remove(staged.parent_path(), ignored);  // fails, as it should, while others are in it
    }
  }
  StagedOutputs(const StagedOutputs&) = delete;
  StagedOutputs& operator=(const StagedOutputs&) = delete;

  // Where to write it.
  fs::path Add(const fs::path& output) {
    outputs_.push_back(output);
    const fs::path staged = site_.staged_path(output);
    std::error_code error;
    fs::remove(staged, error);
    fs::create_directories(staged.parent_path(), error);
    if (error) {
      throw FileSystemError(staged.parent_path().string(), "create the folder", error.value());
    }
    return staged;
  }
  const std::vector<fs::path>& outputs() const { return outputs_; }

 private:
  const TaskSite& site_;
  std::vector<fs::path> outputs_;
};

// The folders with the checkpoints of a task of this run in the scratch folder: their names
// begin alike, and end with the hash of what the result depends on.
class TaskCheckpoints {
 public:
  TaskCheckpoints(const Task& task, const TaskRecord& record, const fs::path& root,
                  const fs::path& scratch_folder)
      : is_on_(task.checkpoint_bytes > 0), scratch_folder_(scratch_folder) {
    Hasher place, content;
    place.Update(fs::absolute(root).lexically_normal().string()).Update(task.name);
    content.Update(record.version).Update(record.options).Update(record.inputs_hash);
    prefix_ = "lsmvs-steps-" + place.HexDigest().substr(0, 16) + "-";
    folder_ = scratch_folder_ / (prefix_ + content.HexDigest());
  }

  // Empty if the task has none.
  fs::path folder() const { return is_on_ ? folder_ : fs::path(); }

  // Of other inputs, options or versions.
  void RemoveOthers() const {
    Remove([&](const fs::path& path) { return path != folder_; });
  }
  void RemoveAll() const {
    Remove([](const fs::path&) { return true; });
  }

 private:
  template <class IsToGo>
  void Remove(const IsToGo& is_to_go) const {
    if (!is_on_) return;
    std::error_code ignored;
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(scratch_folder_, ignored)) {
      const bool is_ours = entry.path().filename().string().starts_with(prefix_);
      if (is_ours && is_to_go(entry.path())) found.push_back(entry.path());
    }
    for (const fs::path& path : found) fs::remove_all(path, ignored);
  }

  const bool is_on_;
  const fs::path scratch_folder_;
  std::string prefix_;
  fs::path folder_;
};

// With a scratch file, and no more than `resident_bytes` in memory; what the file was used for is
// put among the counts.
TaskCounts RunWithScratch(const Task& task, size_t resident_bytes, const TaskSite& site,
                          const TaskRun& run) {
  const uint64_t read = ScratchMemory::BytesRead(), written = ScratchMemory::BytesWritten();
  const ScratchMemory scratch({site.scratch_folder, site.process_bytes + resident_bytes});
  RunContext context = run.context;
  context.memory_budget_bytes = resident_bytes;
  TaskCounts counts = task.run({context, run.outputs, run.add_output, run.checkpoint_folder});
  counts["scratch_bytes"] = static_cast<double>(ScratchMemory::PeakBytes());
  counts["scratch_bytes_read"] = static_cast<double>(ScratchMemory::BytesRead() - read);
  counts["scratch_bytes_written"] = static_cast<double>(ScratchMemory::BytesWritten() - written);
  return counts;
}

// As planned; a task that turns out to need more than there is gets a scratch file all the same.
// `run` has the checkpoint folder for the case that there is a scratch file.
TaskCounts RunWithin(const Task& task, const TaskSite& site, const TaskRun& run) {
  const bool can = task.least_bytes > 0 && ScratchMemory::IsAvailable();
  if (can && site.resident_bytes > 0) {
    return RunWithScratch(task, site.resident_bytes, site, run);
  }
  try {
    // What is there of an earlier run is used all the same.
    const bool goes_on = fs::exists(run.checkpoint_folder);
    return task.run(
        {run.context, run.outputs, run.add_output, goes_on ? run.checkpoint_folder : fs::path()});
  } catch (const MemoryError& error) {
    if (!can) throw;
    LOG(WARNING) << error.what() << "; works with a scratch file in "
                 << site.scratch_folder.string();
  }
  const size_t resident_bytes = std::max(task.least_bytes, run.context.memory_budget_bytes);
  return RunWithScratch(task, resident_bytes, site, run);
}

}  // namespace

void RunTask(const Task& task, const std::string& inputs_hash, const TaskSite& site,
             const RunContext& context, const std::function<void(FinishedTask)>& keep) {
  TaskRecord record;
  record.stage = task.stage;
  record.version = task.version;
  record.options = task.options;
  record.inputs_hash = inputs_hash;
  record.num_threads = context.num_threads();
  record.temporary = task.temporary;
  StagedOutputs staged(task, site);
  std::vector<fs::path> paths;
  for (const fs::path& output : task.outputs) paths.push_back(site.staged_path(output));
  const auto add_output = [&](const fs::path& output) {
    site.check_added(output);
    return staged.Add(output);
  };
  const PeakMemoryWatch memory;
  const Clock::time_point begin = Clock::now();
  const double cpu_begin = CpuSeconds();
  const TaskCheckpoints checkpoints(task, record, site.root, site.scratch_folder);
  checkpoints.RemoveOthers();
  try {
    record.counts = RunWithin(task, site, {context, paths, add_output, checkpoints.folder()});
  } catch (const InputError&) {
    checkpoints.RemoveAll();  // the next start would end the same way
    throw;
  }
  record.seconds = SecondsSince(begin);
  record.cpu_seconds = CpuSeconds() - cpu_begin;
  record.peak_bytes = memory.PeakBytes();
  ReturnFreedMemory();
  record.finished = Now();
  keep({std::move(record), staged.outputs()});
  checkpoints.RemoveAll();
}

void RemoveCheckpoints(const Task& task, const fs::path& root, const fs::path& scratch_folder) {
  TaskCheckpoints(task, TaskRecord(), root, scratch_folder).RemoveAll();
}

}  // namespace lsmvs
