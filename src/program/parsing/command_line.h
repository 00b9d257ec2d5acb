#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "lsmvs/program/parsing/ini_file.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/option_synonyms.h"

namespace lsmvs {

// What a user typed after the name of a command.
struct CommandLine {
  bool help = false;                      // -h, --help
  bool help_all = false;                  // --help_all
  bool version = false;                   // --version
  std::vector<Assignment> assignments;    // in the order typed
  std::set<std::string> without_meaning;  // those given of that list
};

// Parses `--name value`, `--name=value`, `--flag` (a BOOL option without value: 1) and at most one
// argument without a name, which is taken as `positional` (the name of an option; empty: none is
// allowed). Of an option that is given several times the last one counts; of a list, all, in order.
// Values are not interpreted here. Throws UsageError: an unknown option names the nearest known
// one.
CommandLine ParseCommandLine(const std::vector<std::string>& arguments, const OptionSet& options,
                             const std::string& positional,
                             const std::vector<std::string>& without_meaning = {},
                             const OptionSynonyms& synonyms = {});

// Sets the options: those of the ini file first, then the command line's; within each, options
// without a group, then `apply_presets`, then those with one. Ini sections that the command does
// not have are returned for a warning; unknown keys elsewhere throw UsageError. Keys of the ini
// file that are without meaning must have been taken out.
std::vector<std::string> ApplyAssignments(const std::vector<Assignment>& ini_assignments,
                                          const std::vector<Assignment>& line_assignments,
                                          const OptionSet& options,
                                          const std::function<void()>& apply_presets,
                                          const OptionSynonyms& synonyms = {});

// Takes the assignments out of the list that are of options without meaning, and adds their names.
void TakeOutMeaningless(const std::vector<std::string>& without_meaning,
                        std::vector<Assignment>* assignments, std::set<std::string>* names);

}  // namespace lsmvs
