#include "lsmvs/colmap_adapter/colmap_runner.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <sstream>

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

constexpr const char* kMissing =
    "the program `colmap` was not found in PATH; install it (Debian: apt-get install colmap) or "
    "set "
    "COLMAP to its path";
constexpr int kExecFailed = 127;
constexpr useconds_t kPoll_us = 20000;
constexpr int kPollsBeforeKill = 100;
constexpr size_t kQuotedLines = 3;
constexpr size_t kQuotedLineLength = 200;

bool IsExecutable(const fs::path& path) {
  return fs::is_regular_file(path) && ::access(path.c_str(), X_OK) == 0;
}

// As a shell would find it: a name without slash is looked for in PATH. Empty if it is not there.
fs::path FindExecutable(const std::string& name) {
  if (name.find('/') != std::string::npos) return IsExecutable(name) ? fs::absolute(name) : "";
  const char* variable = std::getenv("PATH");
  std::istringstream folders(variable == nullptr ? "" : variable);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path path = fs::path(folder.empty() ? "." : folder) / name;
    if (IsExecutable(path)) return path;
  }
  return {};
}

// Runs in the child after fork: only system calls.
[[noreturn]] void ExecuteInChild(const char* path, char* const* arguments, int output,
                                 pid_t parent) {
  ::setpgid(0, 0);
  // Dies with us, even if we are killed: nothing goes on writing behind the next run's back.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kExecFailed);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int input = ::open("/dev/null", O_RDONLY);
  ::dup2(input, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  ::execv(path, arguments);
  const char* reason = std::strerror(errno);
  if (::write(STDERR_FILENO, reason, std::strlen(reason)) < 0) ::_exit(kExecFailed);
  ::_exit(kExecFailed);
}

// Starts the program in a process group of its own, with its output to the descriptor. Throws
// ExternalToolError.
pid_t Start(const fs::path& executable, const std::vector<std::string>& arguments, int output) {
  std::vector<std::string> words = {executable.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) ExecuteInChild(pointers[0], pointers.data(), output, parent);
  if (child < 0) {
    throw ExternalToolError(
        fmt::format("{}: cannot be started: {}; check memory and process limits",
                    executable.string(), std::strerror(errno)));
  }
  ::setpgid(child, child);
  return child;
}

// Asks the group to end, then makes it.
void Stop(pid_t child) {
  ::kill(-child, SIGTERM);
  for (int poll = 0; poll < kPollsBeforeKill; ++poll) {
    if (::waitpid(child, nullptr, WNOHANG) != 0) break;
    ::usleep(kPoll_us);
  }
  ::kill(-child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

// Waits for the child; its status as of waitpid. `usage` may be null.
int Wait(pid_t child, const RunContext& context, rusage* usage) {
  int status = 0;
  while (true) {
    const pid_t ended = ::wait4(child, &status, WNOHANG, usage);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) {
      throw ExternalToolError(
          fmt::format("cannot wait for colmap: {}; run again", std::strerror(errno)));
    }
    if (context.Cancelled()) {
      Stop(child);
      throw CancelledError();
    }
    ::usleep(kPoll_us);
  }
}

// The last lines of a log that say something, in one line.
std::string LastLines(const fs::path& path) {
  std::ifstream file(path);
  std::deque<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t\r=") == std::string::npos) continue;
    lines.push_back(line.substr(0, kQuotedLineLength));
    if (lines.size() > kQuotedLines) lines.pop_front();
  }
  return fmt::format("{}", fmt::join(lines, " | "));
}

std::string DescribeStatus(int status) {
  if (WIFSIGNALED(status)) return fmt::format("was ended by signal {}", WTERMSIG(status));
  return fmt::format("failed with code {}", WEXITSTATUS(status));
}

int OpenLog(const fs::path& path) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) throw FileSystemError(path.string(), "create the log", errno);
  return descriptor;
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

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
  const std::unique_ptr<std::FILE, CloseFile> output(std::tmpfile());
  if (!available() || !output) return *banner_;
  Wait(Start(executable_, {"-h"}, ::fileno(output.get())), RunContext(1), nullptr);
  std::rewind(output.get());
  char text[4096];
  banner_->assign(text, std::fread(text, 1, sizeof text, output.get()));
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
    status = Wait(Start(executable_, arguments, log), context, &used);
  } catch (...) {
    ::close(log);
    throw;
  }
  ::close(log);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw ExternalToolError(
        fmt::format("colmap {} {}: {}; see {}", arguments.empty() ? "" : arguments.front(),
                    DescribeStatus(status), LastLines(log_path), log_path.string()));
  }
  ToolUsage usage;
  usage.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  usage.cpu_seconds = Seconds(used.ru_utime) + Seconds(used.ru_stime);
  usage.peak_bytes = static_cast<size_t>(used.ru_maxrss) * 1024;
  return usage;
}

bool ColmapRunner::HasCommand(const std::string& name) const {
  const std::unique_ptr<std::FILE, CloseFile> output(std::tmpfile());
  if (!available() || !output) return false;
  Wait(Start(executable_, {"help"}, ::fileno(output.get())), RunContext(1), nullptr);
  std::rewind(output.get());
  std::string text(size_t{1} << 16, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), output.get()));
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (word == name) return true;
  }
  return false;
}

}  // namespace lsmvs
