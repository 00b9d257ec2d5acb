#include "lsmvs/program/parsing/common_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <thread>

#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"

namespace lsmvs {

namespace {

// Bytes of a unit, or 0 if there is no such unit. No unit means gigabytes.
double UnitBytes(std::string unit) {
  std::erase(unit, ' ');
  for (char& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  if (unit.empty()) return 1e9;
  const size_t power = std::string("MGT").find(unit.front());
  if (power == std::string::npos) return 0;
  const std::string rest = unit.substr(1);
  if (rest == "IB") return std::exp2(20 + 10.0 * static_cast<double>(power));
  return rest.empty() || rest == "B" ? std::pow(10, 6 + 3.0 * static_cast<double>(power)) : 0;
}

}  // namespace

size_t ParseBytes(const std::string& option, const std::string& text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  const double unit = error == std::errc() ? UnitBytes(std::string(rest, end)) : 0;
  const double bytes = value * unit;
  if (!(bytes > 0) || bytes > 1e18) {
    throw UsageError(
        fmt::format("--{} is '{}', but must be a size such as 4GB or 500MB", option, text));
  }
  return static_cast<size_t>(bytes);
}

void CommonOptions::Describe(OptionSet* options) {
  options->Add("num_threads", &num_threads,
               "Worker threads; -1 takes all cores. Results do not depend on it.", {-1, 4096});
  options->Add("max_memory", &max_memory,
               "Memory that the program may take, such as 4GB or 500MB; without it nine tenths of "
               "what is free.");
  options->Add("seed", &seed, "Seed of everything random: the same seed gives the same bytes.",
               {0});
  options->Add("log_level", &log_level,
               "Messages on the error stream: 0 all, 1 warnings and errors, 2 errors, 3 none.",
               {0, 3});
  options->Add("project_path", &project_path,
               "Ini file with any of these options, [Group] sections for those with a group; the "
               "command line wins.");
}

bool CommonOptions::Check(std::string* error) const { return CheckOptions(*this, error); }

RunContext CommonOptions::MakeRunContext(const std::atomic<bool>* cancel) const {
  if (num_threads == 0)
    throw UsageError("--num_threads is 0, but must be -1 (all cores) or at least 1");
  const int all_cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  RunContext context(num_threads < 0 ? all_cores : num_threads);
  if (!max_memory.empty()) {
    const size_t allowed = ParseBytes("max_memory", max_memory);
    const size_t in_use = ResidentBytes();
    if (allowed <= in_use) {
      throw MemoryError(fmt::format(
          "--max_memory is {}, but the program takes {} of memory before it has read anything; "
          "allow some hundred MB",
          max_memory, FormatBytes(in_use)));
    }
    context.memory_budget_bytes = allowed - in_use;
  }
  context.seed = static_cast<uint64_t>(seed);
  context.cancel = cancel;
  return context;
}

}  // namespace lsmvs
