#include "lsmvs/colmap_adapter/colmap_runner.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "lsmvs/util/child_process.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

constexpr const char* kMissing =
    "the program `colmap` was not found in PATH; install it (Debian: apt-get install colmap) or "
    "set "
    "COLMAP to its path";
constexpr useconds_t kPoll_us = 20000;

// Starts the program with its output to the descriptor, and waits for its end; its status as of
// waitpid. `usage` may be null. Throws ExternalToolError.
int RunToEnd(const fs::path& executable, const std::vector<std::string>& arguments, int output,
             const RunContext& context, rusage* usage) {
  try {
    ChildProcess child(executable, arguments, output, WhenWeEnd::kEnds);
    while (true) {
      const std::optional<int> status = child.Poll(usage);
      if (status) return *status;
      if (context.Cancelled()) {
        child.Stop();
        throw CancelledError();
      }
      ::usleep(kPoll_us);
    }
  } catch (const CancelledError&) {
    throw;
  } catch (const Error& error) {
    throw ExternalToolError(error.what());
  }
}

int OpenLog(const fs::path& path) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) throw FileSystemError(path.string(), "create the log", errno);
  return descriptor;
}

}  // namespace

ColmapRunner::ColmapRunner() {
  const char* name = std::getenv("COLMAP");
  executable_ = FindExecutable(name != nullptr && *name != '\0' ? name : "colmap");
}

ColmapRunner::ColmapRunner(fs::path executable)
    : executable_(FindExecutable(executable.string())) {}

const std::string& ColmapRunner::Banner() const {
  if (banner_) return *banner_;
  banner_ = "";
  if (!available()) return *banner_;
  constexpr size_t kMaxBanner = 4096;
  banner_ = RunAndRead(executable_, {"-h"}).text.substr(0, kMaxBanner);
  return *banner_;
}

std::string ColmapRunner::Version() const {
  constexpr std::string_view kName = "COLMAP ";
  const std::string& banner = Banner();
  const size_t begin = banner.find(kName);
  if (begin == std::string::npos) return "";
  const size_t first = begin + kName.size();
  return banner.substr(first, banner.find_first_of(" \n,(", first) - first);
}

bool ColmapRunner::HasCuda() const { return Banner().find("with CUDA") != std::string::npos; }

namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

ToolUsage ColmapRunner::Run(const std::vector<std::string>& arguments, const fs::path& log_path,
                            const RunContext& context) const {
  if (!available()) throw ExternalToolError(kMissing);
  const int log = OpenLog(log_path);
  const auto begin = std::chrono::steady_clock::now();
  int status = 0;
  rusage used{};
  try {
    status = RunToEnd(executable_, arguments, log, context, &used);
  } catch (...) {
    ::close(log);
    throw;
  }
  ::close(log);
  if (!HasSucceeded(status)) {
    std::ifstream text(log_path);
    throw ExternalToolError(
        fmt::format("colmap {} {}: {}; see {}", arguments.empty() ? "" : arguments.front(),
                    DescribeStatus(status), LastLines(text), log_path.string()));
  }
  ToolUsage usage;
  usage.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  usage.cpu_seconds = Seconds(used.ru_utime) + Seconds(used.ru_stime);
  usage.peak_bytes = static_cast<size_t>(used.ru_maxrss) * 1024;
  return usage;
}

bool ColmapRunner::HasCommand(const std::string& name) const {
  if (!available()) return false;
  std::istringstream words(RunAndRead(executable_, {"help"}).text);
  for (std::string word; words >> word;) {
    if (word == name) return true;
  }
  return false;
}

}  // namespace lsmvs
