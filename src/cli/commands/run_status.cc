#include "lsmvs/workflow/show_run_status.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeRunStatusCommand() {
  CommandInfo info = {
      "run_status",
      "How far the run in a workspace is",
      "Says, from another terminal or machine, which stage a run is at, how far it is, when "
      "the stage will end, and which of its jobs run and wait; and what is on record. "
      "Changes nothing.",
      {"lsmvs run_status project/dense/0"},
      {"workspace_path"},
      "workspace_path"};
  return MakeOptionsCommand<RunStatusOptions>(std::move(info), ShowRunStatus);
}

}  // namespace lsmvs
