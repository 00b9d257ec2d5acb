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

// For a struct of options, which `run` receives.
template <class Options>
int RunGenerator(const std::string& usage, const std::vector<std::string>& arguments,
                 void (*run)(Options)) {
  Options options;
  OptionSet set;
  options.Describe(&set);
  return RunGenerator(usage, set, arguments, [&] { run(options); });
}

}  // namespace lsmvs
