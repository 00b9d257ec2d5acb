#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/execution/run_lock.h"
#include "lsmvs/execution/run_record.h"
#include "lsmvs/execution/task.h"

namespace lsmvs {

// What a folder remembers of its runs, and how results get their names in it:
// <root>/lsmvs/run.json, run.lock, staging/.
//
// A task writes its outputs to staging paths. Publish() puts what they are on record first and
// renames them then: whenever the process is killed, the next one knows for each file whether it is
// ours, and ends the renaming. run.json is written once a task.
class RunStore {
 public:
  // Locks the folder, reads the record and ends a publication that was cut short. `program` is put
  // on record.
  RunStore(const std::filesystem::path& root, const std::string& program);
  ~RunStore();
  RunStore(const RunStore&) = delete;
  RunStore& operator=(const RunStore&) = delete;

  FileTable& files() { return record_.files; }
  const std::map<std::string, TaskRecord>& tasks() const { return record_.tasks; }

  // Where a task writes: <root>/lsmvs/staging/<relative path>, or a hidden folder beside outputs
  // that are not below the root.
  std::filesystem::path StagedPath(const std::filesystem::path& output) const;
  // Removes what an earlier task left at the staging paths, and makes their folders.
  void PrepareStaging(const Task& task) const;
  void DropStaging(const Task& task) const;

  // Renames the staged files to the task's outputs. `record.outputs` is filled in here.
  void Publish(const Task& task, TaskRecord record);

  // Writes run.json.
  void Save();

 private:
  void FinishPublishing();

  std::filesystem::path root_;
  RunLock lock_;
  RunRecord record_;
};

}  // namespace lsmvs
