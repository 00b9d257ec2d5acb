#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

// For tests of memory: sanitizers take several times as much, and there is no scratch memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SKIP_WITH_SANITIZERS GTEST_SKIP() << "memory is counted without sanitizers"
#else
#define SKIP_WITH_SANITIZERS static_cast<void>(0)
#endif

namespace lsmvs {

struct ProgramResult {
  int exit_code = -1;  // -1: ended by a signal
  int signal = 0;
  std::string out, err;  // what it printed
  double seconds = 0;
  // Highest resident size, as the kernel counts it for the parent (getrusage); at least that of the
  // calling process when it started the program.
  size_t peak_bytes = 0;

  // The lines of `err` that begin with "error: ".
  std::vector<std::string> Errors() const;
};

struct ProgramOptions {
  // Sent after the delay; the program may have ended by then.
  std::optional<std::chrono::microseconds> signal_after;
  // Or when this is true, which is asked every 0.2 ms.
  std::function<bool()> signal_when;
  int signal = 9;
  // Runs in the child before the program starts.
  std::function<void()> before_exec;
};

// Runs a program of the build and waits for it. `name` is "lsmvs" or "lsmvs-mesher".
ProgramResult RunProgram(const std::string& name, const std::vector<std::string>& arguments,
                         const ProgramOptions& options = {});

// Fails the test unless the program ended with the code and exactly one error line that holds all
// the texts.
void ExpectError(const ProgramResult& result, int exit_code, const std::vector<std::string>& texts);
// Fails the test, quoting what was printed, unless the program ended with code 0.
void ExpectSuccess(const ProgramResult& result);

}  // namespace lsmvs
