#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/execution/task.h"

namespace lsmvs {

// Two passes over six views, then one task that takes all, as in kill_test.cc, for the driver and
// for its jobs; what the first pass gives goes when the second has read it. What is written depends
// on ROOT/photo and on `word` alone.
//
// ROOT/hooks/NAME makes a task do something first; it holds lines of which one is taken off at each
// start, the last one when the file is empty:
//   crash          the process kills itself
//   sleep SECONDS
//   hold BYTES     takes so much memory for some seconds
//   wrong          InputError
//   memory BYTES   MemoryError unless the process may take so much
//   change         ROOT/photo gets other contents
// ROOT/starts/NAME gets a line for each start.
std::vector<Task> MakeJobTasks(const std::filesystem::path& root, const std::string& word);

// Adds a line to ROOT/hooks/NAME.
void AddHook(const std::filesystem::path& root, const std::string& task, const std::string& hook);
// How often a task was started.
size_t NumStarts(const std::filesystem::path& root, const std::string& task);

}  // namespace lsmvs
