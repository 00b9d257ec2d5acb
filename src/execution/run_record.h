#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/execution/file_table.h"
#include "lsmvs/execution/task.h"

namespace lsmvs {

// What is kept of a task that has finished.
struct TaskRecord {
  std::string stage, version;
  std::string options;               // as the task had them
  std::string inputs_hash;           // over the names and contents of all inputs
  std::vector<std::string> outputs;  // keys of the file table
  double seconds = 0, cpu_seconds = 0;
  uint64_t peak_bytes = 0;  // highest resident size of the process meanwhile
  int num_threads = 0;
  bool temporary = false;  // as the task was: its outputs may be gone without being missed
  std::string finished;    // UTC, ISO 8601
  TaskCounts counts;
};

// A task whose results are complete but perhaps not all under their own names yet.
struct PublishingRecord {
  std::string name;
  TaskRecord task;
  std::vector<FileTable::Entry> files;  // one for each of task.outputs
};

// As one line of JSON and back. Throws std::exception for anything else.
std::string ToText(const PublishingRecord& publishing);
PublishingRecord PublishingFromText(const std::string& text);

// The content of run.json.
struct RunRecord {
  std::string program;  // name and version of the program that wrote it
  std::map<std::string, TaskRecord> tasks;
  std::optional<PublishingRecord> publishing;
  FileTable files;

  explicit RunRecord(const std::filesystem::path& root) : files(root) {}
};

// An absent file gives an empty record. Throws InputError if it is not a run record.
RunRecord ReadRunRecord(const std::filesystem::path& path, const std::filesystem::path& root);
// Atomic.
void WriteRunRecord(const std::filesystem::path& path, const RunRecord& record);

}  // namespace lsmvs
