#pragma once

#include <cstddef>
#include <filesystem>

#include "lsmvs/execution/run_record.h"

namespace lsmvs {

// What was published since run.json was written, a line each: a run of many tasks would write that
// file for each of them. Lines are on the disk when Append() has returned.
class RunJournal {
 public:
  explicit RunJournal(std::filesystem::path path) : path_(std::move(path)) {}
  ~RunJournal();
  RunJournal(const RunJournal&) = delete;
  RunJournal& operator=(const RunJournal&) = delete;

  // Throws FileSystemError.
  void Append(const PublishingRecord& publishing);
  // After run.json was written.
  void Remove();
  size_t num_bytes() const { return num_bytes_; }

  // Brings the record up to date. All but the last line are of publications that were finished; the
  // last one becomes record->publishing. A line that was cut off does not count. Whether there was
  // a line.
  static bool Replay(const std::filesystem::path& path, RunRecord* record);

 private:
  const std::filesystem::path path_;
  int descriptor_ = -1;
  size_t num_bytes_ = 0;
};

}  // namespace lsmvs
