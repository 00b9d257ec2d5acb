#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/program/console.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// A job of a run on many machines, which repeats the command that started the run.
struct CommandJob {
  std::filesystem::path root;  // of the run
  JobNumber number;
};

// What a command runs with.
struct CommandContext {
  RunContext run;             // threads, seed, memory budget, cancel; progress goes to `console`
  Console* console;           // Begin() a phase, let run.Report() move it, End() it
  size_t process_bytes = 0;   // that the process took when `run` got its memory budget
  DriverCommand driver = {};  // this command, for jobs to repeat
  // Whether the user said how many threads and how much memory.
  bool has_num_threads = false, has_max_memory = false;
  // Set in a job: only its tasks are run.
  std::optional<CommandJob> job = {};

  // That the process as a whole may take.
  size_t AllowedBytes() const { return process_bytes + run.memory_budget_bytes; }
};

}  // namespace lsmvs
