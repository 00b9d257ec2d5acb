#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "lsmvs/execution/engine.h"

namespace lsmvs {

// How far a run is, for whoever asks from elsewhere: <root>/lsmvs/status.json. It is there while
// the run is at work, and after one that was killed.
struct RunStatus {
  std::string engine, stage, host;
  int64_t process_id = 0;
  int64_t began = 0, updated = 0;  // of the stage, of this; seconds since 1970
  double fraction_before = 0;      // of the stage, when it began
  double fraction = 0;
  size_t num_tasks = 0, num_done = 0;  // of the stage
  JobCounts jobs;
};

// Atomic. A status that cannot be written is left out.
void WriteRunStatus(const std::filesystem::path& root, const RunStatus& status);
void RemoveRunStatus(const std::filesystem::path& root);
// Nothing if there is none.
std::optional<RunStatus> ReadRunStatus(const std::filesystem::path& root);

}  // namespace lsmvs
