#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "lsmvs/program/command.h"

namespace lsmvs {

// The commands of `lsmvs`, in the order in which a reconstruction meets them.
const std::vector<CommandFactory>& CommandTable();

}  // namespace lsmvs
