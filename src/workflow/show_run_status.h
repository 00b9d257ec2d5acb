#pragma once

#include <string>

#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct RunStatusOptions {
  // Dense workspace, or a project with several.
  std::string workspace_path;

  void Describe(OptionSet* options);
};

// Prints which stage the run in each workspace is at, how far it is, its jobs, and what is on
// record. Changes nothing.
void ShowRunStatus(const RunStatusOptions& options, const CommandContext& context);

}  // namespace lsmvs
