#include "program_runner.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <thread>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

std::string ReadAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// In the child: does not return.
void Execute(const fs::path& program, const std::vector<std::string>& arguments,
             const fs::path& out, const fs::path& err, const ProgramOptions& options) {
  ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT, 0600), STDOUT_FILENO);
  ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
  if (options.before_exec) options.before_exec();
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  ::_exit(127);
}

// Leaves the child to be waited for.
bool HasEnded(pid_t child) {
  siginfo_t info = {};
  return ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
         info.si_pid == child;
}

}  // namespace

std::vector<std::string> ProgramResult::Errors() const {
  std::vector<std::string> errors;
  std::istringstream lines(err);
  std::string line;
  while (std::getline(lines, line)) {
    if (line.starts_with("error: ")) errors.push_back(line);
  }
  return errors;
}

ProgramResult RunProgram(const std::string& name, const std::vector<std::string>& arguments,
                         const ProgramOptions& options) {
  const TemporaryFolder output;
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    Execute(ProgramFolder() / name, arguments, output.path() / "out", output.path() / "err",
            options);
  }
  if (options.signal_after) {
    std::this_thread::sleep_for(*options.signal_after);
    ::kill(child, options.signal);
  }
  while (options.signal_when && !HasEnded(child)) {
    if (options.signal_when()) ::kill(child, options.signal);
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  int status = 0;
  rusage usage = {};
  ::wait4(child, &status, 0, &usage);
  ProgramResult result;
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.peak_bytes = static_cast<size_t>(usage.ru_maxrss) * 1024;
  result.out = ReadAll(output.path() / "out");
  result.err = ReadAll(output.path() / "err");
  return result;
}

void ExpectError(const ProgramResult& result, int exit_code,
                 const std::vector<std::string>& texts) {
  EXPECT_EQ(result.exit_code, exit_code) << "signal " << result.signal << "\n" << result.err;
  const std::vector<std::string> errors = result.Errors();
  ASSERT_EQ(errors.size(), 1u) << result.err;
  for (const std::string& text : texts) EXPECT_THAT(errors.front(), testing::HasSubstr(text));
}

void ExpectSuccess(const ProgramResult& result) {
  EXPECT_EQ(result.exit_code, 0) << "signal " << result.signal << "\n" << result.out << result.err;
}

}  // namespace lsmvs
