#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

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

// A command of a program. Its options are described once: from that come parsing, --help, manual
// pages, completion, ini keys and bound checks. See OptionsCommand for the usual one.
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

using CommandFactory = std::function<std::unique_ptr<Command>()>;

}  // namespace lsmvs
