#include "lsmvs/synthetic/generator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

void PrintHelp(const std::string& usage, const OptionSet& options) {
  fmt::print("{}\n", usage);
  for (const OptionSet::Entry& entry : options.entries()) {
    fmt::print("  --{:<24} {} ({}{}{}; default {})\n", entry.name, entry.help, entry.type,
               entry.bounds.empty() ? "" : " ", entry.bounds,
               entry.default_value.empty() ? "none" : entry.default_value);
  }
}

void Parse(const std::vector<std::string>& arguments, const OptionSet& options) {
  for (size_t i = 0; i < arguments.size(); i += 2) {
    const OptionSet::Entry* entry =
        arguments[i].starts_with("--") ? options.Find(arguments[i].substr(2)) : nullptr;
    if (entry == nullptr) throw UsageError("unknown option '" + arguments[i] + "'; see --help");
    if (i + 1 == arguments.size()) throw UsageError(arguments[i] + " needs a value");
    entry->set(arguments[i + 1]);
  }
}

}  // namespace

int RunGenerator(const std::string& usage, const OptionSet& options,
                 const std::vector<std::string>& arguments, const std::function<void()>& run) {
  const auto is_help = [](const std::string& text) { return text == "--help" || text == "-h"; };
  try {
    if (std::any_of(arguments.begin(), arguments.end(), is_help)) {
      PrintHelp(usage, options);
    } else {
      Parse(arguments, options);
      run();
    }
    return static_cast<int>(ExitCode::kOk);
  } catch (const Error& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "internal error: {}\n", error.what());
    return static_cast<int>(ExitCode::kInternal);
  }
}

}  // namespace lsmvs
