#include "lsmvs/program/run_program.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <set>

#include "lsmvs/program/help/help_text.h"
#include "lsmvs/program/parsing/command_line.h"
#include "lsmvs/program/parsing/common_options.h"
#include "lsmvs/program/terminal/progress_display.h"
#include "lsmvs/program/terminal/signals.h"
#include "lsmvs/program/version.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/util/nearest_name.h"
#include "lsmvs/util/scratch_memory.h"

namespace lsmvs {

namespace {

int Fail(ExitCode code, const std::string& message) {
  std::fflush(stdout);
  fmt::print(stderr, "error: {}\n", message);
  return static_cast<int>(code);
}

// Runs `body` and turns what it throws into a line and a code.
int Guarded(const std::function<void()>& body) {
  try {
    body();
    return static_cast<int>(ExitCode::kOk);
  } catch (const Error& error) {
    return Fail(error.code(), error.what());
  } catch (const ScratchFullError& error) {
    return Fail(ExitCode::kFileSystem, error.what());
  } catch (const std::bad_alloc&) {
    return Fail(
        ExitCode::kMemory,
        "out of memory; lower --quality or --max_image_size, or free memory on this machine");
  } catch (const std::exception& error) {
    return Fail(ExitCode::kInternal,
                fmt::format("internal error: {}; this is a bug, please report it with the command "
                            "that you ran ({})",
                            error.what(), VersionLine()));
  }
}

void SetUpLibraries(int log_level) {
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = log_level;
  FLAGS_log_prefix = log_level == 0;
  if (!google::IsGoogleLoggingInitialized()) google::InitGoogleLogging("lsmvs");
  cv::setNumThreads(1);  // our own threads do the work
  cv::utils::logging::setLogLevel(
      cv::utils::logging::LOG_LEVEL_SILENT);  // errors come as exceptions
}

void CheckAll(const CommandInfo& info, const OptionSet& options) {
  for (const std::string& name : info.required) {
    if (!options.Find(name)->get().empty()) continue;
    const bool positional = name == info.positional;
    throw UsageError(
        positional
            ? fmt::format("--{} is missing: name the folder of the workspace; see --help", name)
            : fmt::format("--{} is missing; see --help", name));
  }
  std::string error;
  if (!options.Check(&error)) throw UsageError(error);
}

void WarnOfIgnored(const std::vector<std::string>& groups) {
  if (groups.empty()) return;
  LOG(WARNING) << fmt::format("the ini file's {} [{}] {} not used by this command",
                              groups.size() == 1 ? "section" : "sections",
                              fmt::join(groups, "], ["), groups.size() == 1 ? "is" : "are");
}

void WarnOfMeaningless(const std::set<std::string>& names) {
  if (names.empty()) return;
  LOG(WARNING) << fmt::format("{} {} no meaning here and {} ignored",
                              "--" + fmt::format("{}", fmt::join(names, ", --")),
                              names.size() == 1 ? "has" : "have", names.size() == 1 ? "is" : "are");
}

// Path of the program that runs jobs, which lies beside this one.
std::string JobProgram() {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  return (error ? std::filesystem::path("lsmvs") : self.parent_path() / "lsmvs").string();
}

void RunWithOptions(const CommonOptions& common, const std::vector<std::string>& arguments,
                    const std::optional<CommandJob>& job, Command* command) {
  const std::atomic<bool>* cancel = InstallSignalHandlers();
  ProgressDisplay display;
  const size_t process_bytes = ResidentBytes();
  CommandContext context{common.MakeRunContext(cancel), &display, process_bytes};
  context.run.set_progress(&display);
  context.driver = {JobProgram(), command->Info().name, arguments};
  context.has_num_threads = common.num_threads >= 0;
  context.has_max_memory = !common.max_memory.empty();
  context.job = job;
  try {
    command->Run(context);
  } catch (...) {
    display.Abandon();
    throw;
  }
}

void ParseAndRun(const std::string& program, Command* command,
                 const std::vector<std::string>& arguments, const OptionSynonyms& synonyms,
                 const std::optional<CommandJob>& job = std::nullopt) {
  CommonOptions common;
  OptionSet own_options, common_options, all_options;
  command->Describe(&own_options);
  common.Describe(&common_options);
  command->Describe(&all_options);
  common.Describe(&all_options);
  const CommandInfo info = command->Info();
  CommandLine line =
      ParseCommandLine(arguments, all_options, info.positional, info.without_meaning, synonyms);
  if (line.help || line.help_all) {
    fmt::print("{}", CommandHelp(program, info, own_options, common_options, line.help_all));
    return;
  }
  if (line.version) {
    fmt::print("{}\n", VersionLine());
    return;
  }
  for (const auto& [name, text] : line.assignments) {
    if (name == "project_path") common.project_path = text;
  }
  std::vector<Assignment> ini;
  if (!common.project_path.empty()) ini = ReadIniFile(common.project_path);
  TakeOutMeaningless(info.without_meaning, &ini, &line.without_meaning);
  const std::vector<std::string> ignored = ApplyAssignments(
      ini, line.assignments, all_options, [&] { command->ApplyPresets(); }, synonyms);
  SetUpLibraries(common.log_level);
  WarnOfIgnored(ignored);
  WarnOfMeaningless(line.without_meaning);
  CheckAll(info, all_options);
  RunWithOptions(common, arguments, job, command);
}

[[noreturn]] void ThrowUnknownCommand(const std::string& name,
                                      const std::vector<CommandFactory>& commands) {
  std::vector<std::string> names;
  for (const CommandFactory& make : commands) names.push_back(make()->Info().name);
  const std::string nearest = NearestName(name, names);
  throw UsageError(nearest.empty()
                       ? fmt::format("unknown command '{}'; `lsmvs help` lists them", name)
                       : fmt::format("unknown command '{}'; did you mean '{}'?", name, nearest));
}

}  // namespace

int RunCommand(const std::string& program, Command* command,
               const std::vector<std::string>& arguments, const OptionSynonyms& synonyms) {
  ReturnLargeBlocksWhenFreed();
  return Guarded([&] { ParseAndRun(program, command, arguments, synonyms); });
}

void RunCommandForJob(Command* command, const std::vector<std::string>& arguments,
                      const CommandJob& job, const OptionSynonyms& synonyms) {
  ParseAndRun(command->Info().name, command, arguments, synonyms, job);
}

int RunCommandTable(const std::vector<CommandFactory>& commands,
                    const std::vector<std::string>& arguments, const OptionSynonyms& synonyms) {
  const std::string name = arguments.empty() ? "help" : arguments.front();
  if (name == "help" || name == "-h" || name == "--help") {
    fmt::print("{}", OverviewHelp(commands));
    return static_cast<int>(arguments.empty() ? ExitCode::kUsage : ExitCode::kOk);
  }
  if (name == "--version") {
    fmt::print("{}\n", VersionLine());
    return static_cast<int>(ExitCode::kOk);
  }
  for (const CommandFactory& make : commands) {
    const std::unique_ptr<Command> command = make();
    if (command->Info().name != name) continue;
    return RunCommand("lsmvs " + name, command.get(), {arguments.begin() + 1, arguments.end()},
                      synonyms);
  }
  return Guarded([&] { ThrowUnknownCommand(name, commands); });
}

}  // namespace lsmvs
