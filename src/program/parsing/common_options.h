#pragma once

#include <atomic>
#include <string>

#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Options that every command has.
struct CommonOptions {
  // Worker threads; -1 takes all cores. Results do not depend on it.
  int num_threads = -1;
  // Bytes the program may take, as "4GB" or "500MB" (a bare number means GB); empty: 90 % of what
  // is free.
  std::string max_memory;
  // Seed of everything random.
  int seed = 0;
  // 0 all messages, 1 warnings and errors, 2 errors, 3 nothing but a crash.
  int log_level = 1;
  // Ini file with the same options, sections as groups; the command line wins.
  std::string project_path;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const;

  // The context to run with; `cancel` outlives it. Throws UsageError;
  // MemoryError if max_memory is less than what the process takes already.
  RunContext MakeRunContext(const std::atomic<bool>* cancel) const;
};

// "4GB", "1.5 G", "500MB", "4" (GB), "4GiB" in bytes (1 GB = 10^9, 1 GiB = 2^30). Throws UsageError
// that names `option`.
size_t ParseBytes(const std::string& option, const std::string& text);

}  // namespace lsmvs
