#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lsmvs/util/option_set.h"

namespace lsmvs {

// The frame of the programs that make test data: --help prints `usage` and the options, other
// arguments set them, then `run` runs. Prints errors; returns the code to exit with.
int RunGenerator(const std::string& usage, const OptionSet& options,
                 const std::vector<std::string>& arguments, const std::function<void()>& run);

}  // namespace lsmvs
