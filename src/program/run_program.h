#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lsmvs/program/command.h"
#include "lsmvs/util/option_synonyms.h"

namespace lsmvs {

// Runs one command from its arguments to its exit code: parses, prints help or version, sets up
// logging, signals and threads, runs, and turns every exception into one line on the error stream
// and a code of ExitCode. `program` is what is typed before the arguments, for the help.
// `synonyms`: other names that its options may be given by.
int RunCommand(const std::string& program, Command* command,
               const std::vector<std::string>& arguments, const OptionSynonyms& synonyms = {});

// Runs the command for the tasks of a job only. Throws what it throws.
void RunCommandForJob(Command* command, const std::vector<std::string>& arguments,
                      const CommandJob& job, const OptionSynonyms& synonyms);

// `lsmvs COMMAND ...`: finds the command in the table.
int RunCommandTable(const std::vector<CommandFactory>& commands,
                    const std::vector<std::string>& arguments, const OptionSynonyms& synonyms = {});

}  // namespace lsmvs
