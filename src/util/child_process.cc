#include "lsmvs/util/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <sstream>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

constexpr int kExecFailed = 127;
constexpr useconds_t kPoll_us = 20000;
constexpr int kPollsBeforeKill = 100;
constexpr size_t kQuotedLines = 3;
constexpr size_t kQuotedLineLength = 200;

bool IsExecutable(const fs::path& path) {
  return fs::is_regular_file(path) && ::access(path.c_str(), X_OK) == 0;
}

// Runs in the child after fork: only system calls. `parent`: 0 if it goes on without it.
[[noreturn]] void ExecuteInChild(const char* path, char* const* arguments, int output,
                                 pid_t parent) {
  ::setpgid(0, 0);
  if (parent != 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(kExecFailed);
  }
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

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

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

ChildProcess::ChildProcess(const fs::path& executable, const std::vector<std::string>& arguments,
                           int output, WhenWeEnd when_we_end) {
  std::vector<std::string> words = {executable.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t parent = when_we_end == WhenWeEnd::kEnds ? ::getpid() : 0;
  id_ = ::fork();
  if (id_ == 0) ExecuteInChild(pointers[0], pointers.data(), output, parent);
  if (id_ < 0) {
    throw Error(ExitCode::kExternalTool,
                fmt::format("{}: cannot be started: {}; check memory and process limits",
                            executable.string(), std::strerror(errno)));
  }
  ::setpgid(id_, id_);
}

std::optional<int> ChildProcess::Poll(rusage* usage) {
  if (status_) return status_;
  int status = 0;
  const pid_t ended = ::wait4(id_, &status, WNOHANG, usage);
  if (ended == id_) status_ = status;
  if (ended < 0 && errno != EINTR) {
    throw Error(ExitCode::kExternalTool, fmt::format("cannot wait for process {}: {}; run again",
                                                     id_, std::strerror(errno)));
  }
  return status_;
}

void ChildProcess::Stop() {
  if (status_) return;
  ::kill(-id_, SIGTERM);
  for (int poll = 0; poll < kPollsBeforeKill && !Poll(); ++poll) ::usleep(kPoll_us);
  ::kill(-id_, SIGKILL);
  while (!Poll()) ::usleep(kPoll_us);
}

bool HasSucceeded(int status) { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }

std::string DescribeStatus(int status) {
  if (WIFSIGNALED(status)) return fmt::format("was ended by signal {}", WTERMSIG(status));
  return fmt::format("failed with code {}", WEXITSTATUS(status));
}

ProgramOutput RunAndRead(const fs::path& executable, const std::vector<std::string>& arguments) {
  const std::unique_ptr<std::FILE, CloseFile> file(std::tmpfile());
  if (!file) throw FileSystemError(P_tmpdir, "create a temporary file", errno);
  ChildProcess child(executable, arguments, ::fileno(file.get()), WhenWeEnd::kEnds);
  ProgramOutput output;
  std::optional<int> status;
  while (!(status = child.Poll())) ::usleep(kPoll_us / 10);
  output.status = *status;
  std::rewind(file.get());
  char part[4096];
  while (const size_t count = std::fread(part, 1, sizeof part, file.get())) {
    output.text.append(part, count);
  }
  return output;
}

std::string LastLines(std::istream& text) {
  std::deque<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    if (line.find_first_not_of(" \t\r=") == std::string::npos) continue;
    lines.push_back(line.substr(0, kQuotedLineLength));
    if (lines.size() > kQuotedLines) lines.pop_front();
  }
  return fmt::format("{}", fmt::join(lines, " | "));
}

}  // namespace lsmvs
