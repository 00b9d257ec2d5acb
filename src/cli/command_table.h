#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "lsmvs/cli/command.h"

namespace lsmvs {

using CommandFactory = std::function<std::unique_ptr<Command>()>;

// The commands of `lsmvs`, in the order in which a reconstruction meets them.
const std::vector<CommandFactory>& CommandTable();

}  // namespace lsmvs
