#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lsmvs/cli/command.h"
#include "lsmvs/cli/command_table.h"

namespace lsmvs {

// Runs one command from its arguments to its exit code: parses, prints help or version, sets up
// logging, signals and threads, runs, and turns every exception into one line on the error stream
// and a code of ExitCode. `program` is what is typed before the arguments, for the help.
int RunCommand(const std::string& program, Command* command,
               const std::vector<std::string>& arguments);

// Runs the command for the tasks of a job only. Throws what it throws.
void RunCommandForJob(Command* command, const std::vector<std::string>& arguments,
                      const CommandJob& job);

// `lsmvs COMMAND ...`: finds the command in the table.
int RunCommandTable(const std::vector<CommandFactory>& commands,
                    const std::vector<std::string>& arguments);

}  // namespace lsmvs
