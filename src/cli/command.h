#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/cli/progress_display.h"
#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What --help says of a command, and which of its options must be given.
struct CommandInfo {
  std::string name;     // "stereo_fusion", as typed
  std::string summary;  // one line for the list of commands
  // Paragraphs separated by '\n': what it reads, what it writes, what it does with files that are
  // there. Wrapped when printed.
  std::string details;
  std::vector<std::string> examples;  // whole command lines
  std::vector<std::string> required;  // names of options without which it cannot run
  std::string positional;  // name of the option that may be given without its name, or empty
  // Options of COLMAP's counterpart that have no meaning here: taken with a value, and with one
  // warning, so that people's scripts run.
  std::vector<std::string> without_meaning = {};
  bool is_internal = false;  // called by our own programs: not in the list of commands
};

// A job of a run on many machines, which repeats the command that started the run.
struct CommandJob {
  std::filesystem::path root;  // of the run
  JobNumber number;
};

// What a command runs with.
struct CommandContext {
  RunContext run;             // threads, seed, memory budget, cancel; progress goes to `display`
  ProgressDisplay* display;   // Begin() a phase, let run.Report() move it, End() it
  size_t process_bytes = 0;   // that the process took when `run` got its memory budget
  DriverCommand driver = {};  // this command, for jobs to repeat
  // Whether the user said how many threads and how much memory.
  bool has_num_threads = false, has_max_memory = false;
  // Set in a job: only its tasks are run.
  std::optional<CommandJob> job = {};
};

// A command of `lsmvs`: one file under commands/ that derives from this, and one line in
// command_table.cc. Its options are members, described once: from that come parsing, --help, ini
// keys and bound checks.
class Command {
 public:
  virtual ~Command() = default;

  virtual CommandInfo Info() const = 0;
  // Adds all options; the pointers are to members of this object. The common ones (CommonOptions)
  // come by themselves.
  virtual void Describe(OptionSet* options) = 0;
  // Called when the options without a group are set and before those with one (--Group.field) are:
  // a preset such as --quality changes defaults here and an explicit --Group.field still wins.
  virtual void ApplyPresets() {}
  // Does the work. Results go to files and stdout. Throws lsmvs::Error; anything else is taken as a
  // bug.
  virtual void Run(const CommandContext& context) = 0;
};

}  // namespace lsmvs
