#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace lsmvs {

// As a shell would find it: a name without slash is looked for in PATH. Empty if it is not there.
std::filesystem::path FindExecutable(const std::string& name);

// What happens to a program when we end first.
enum class WhenWeEnd {
  kEnds,    // it is killed, even if we are killed
  kGoesOn,  // it does not notice
};

// Another program, in a process group of its own, without input.
class ChildProcess {
 public:
  // Starts it with standard and error output to the descriptor. Throws Error(kExternalTool) if no
  // process can be made. A program that cannot be run ends with code 127, the reason in its output.
  ChildProcess(const std::filesystem::path& executable, const std::vector<std::string>& arguments,
               int output, WhenWeEnd when_we_end);

  pid_t id() const { return id_; }
  // Its status as of waitpid once it has ended; nothing before. `usage` may be null.
  std::optional<int> Poll(rusage* usage = nullptr);
  // Asks the group to end; kills it after two seconds.
  void Stop();

 private:
  pid_t id_ = -1;
  std::optional<int> status_;
};

bool HasSucceeded(int status);
// "failed with code 3", "was ended by signal 9".
std::string DescribeStatus(int status);

// Runs a program to its end.
struct ProgramOutput {
  int status = 0;    // as of waitpid
  std::string text;  // what it printed, errors too
};
ProgramOutput RunAndRead(const std::filesystem::path& executable,
                         const std::vector<std::string>& arguments);

// The last lines of a text that say something, cut to a readable length, in one line.
std::string LastLines(std::istream& text);

}  // namespace lsmvs
