#pragma once

#include <memory>

#include "lsmvs/cli/command.h"

// Makers of the commands: each is defined in the file of its name in this folder.

namespace lsmvs {

std::unique_ptr<Command> MakeMeshComparer();
std::unique_ptr<Command> MakeMeshEvaluator();
std::unique_ptr<Command> MakeMeshRenderer();
std::unique_ptr<Command> MakeQuasiDenseMatcher();

}  // namespace lsmvs
