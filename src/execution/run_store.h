#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lsmvs/execution/run_lock.h"
#include "lsmvs/execution/run_record.h"
#include "lsmvs/execution/task.h"

namespace lsmvs {

class RunJournal;

// What a folder remembers of its runs, and how results get their names in it:
// <root>/lsmvs/run.json, run.journal, run.lock, staging/.
//
// A task writes its outputs to staging paths. Publish() puts what they are on record first and
// renames them then: whenever the process is killed, the next one knows for each file whether it is
// ours, and ends the renaming. It puts a line into the journal; run.json is written by Save(), when
// the journal has become as long as it, and in the end.
class RunStore {
 public:
  // Locks the folder, reads the record and ends a publication that was cut short. `program` is put
  // on record.
  RunStore(const std::filesystem::path& root, const std::string& program);
  ~RunStore();
  RunStore(const RunStore&) = delete;
  RunStore& operator=(const RunStore&) = delete;

  const std::filesystem::path& root() const { return root_; }
  FileTable& files() { return record_.files; }
  const std::map<std::string, TaskRecord>& tasks() const { return record_.tasks; }

  // Where a task writes: <root>/lsmvs/staging/<relative path>, or a hidden folder beside outputs
  // that are not below the root.
  std::filesystem::path StagedPath(const std::filesystem::path& output) const;

  // Renames the staged files to the outputs of the task of that name: Task::outputs, then those
  // that its run added. `record.outputs` is filled in here. What the task wrote before and does not
  // any more is removed, if it is still what the task made.
  void Publish(const std::string& name, std::span<const std::filesystem::path> outputs,
               TaskRecord record);

  // The same for files that lie elsewhere, with hashes that are known: `staged` and `hashes`, one
  // for each of the outputs.
  void Publish(const std::string& name, std::span<const std::filesystem::path> outputs,
               std::span<const std::filesystem::path> staged, std::span<const std::string> hashes,
               TaskRecord record);

  // Writes run.json, which then says all.
  void Save();

 private:
  void Publish(PublishingRecord publishing);
  void FinishPublishing();
  void RemoveAbandoned(const std::string& name, const std::vector<std::string>& old_keys);

  std::filesystem::path root_;
  RunLock lock_;
  RunRecord record_;
  std::unique_ptr<RunJournal> journal_;
  size_t saved_bytes_ = 0;  // of run.json
};

// What a folder remembers, without locking or changing it: while a run is at work, what it has
// finished. Throws InputError.
RunRecord ReadRecordOf(const std::filesystem::path& root);

}  // namespace lsmvs
