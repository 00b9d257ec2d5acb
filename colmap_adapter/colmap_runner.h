#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/util/error.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// The `colmap` executable is missing or failed.
class ExternalToolError : public Error {
 public:
  explicit ExternalToolError(const std::string& message)
      : Error(ExitCode::kExternalTool, message) {}
};

// What a command took.
struct ToolUsage {
  double seconds = 0;      // wall clock
  double cpu_seconds = 0;  // of all its threads
  size_t peak_bytes = 0;   // highest resident size
};

// Runs commands of the `colmap` executable: $COLMAP if that is set, else `colmap` of the PATH.
class ColmapRunner {
 public:
  // Looks for the executable; it may be missing.
  ColmapRunner();
  // Uses this executable.
  explicit ColmapRunner(std::filesystem::path executable);

  bool available() const { return !executable_.empty(); }
  // Empty if not available.
  const std::filesystem::path& executable() const { return executable_; }

  // "3.8", "4.1.1"; empty if it cannot be told. Runs `colmap -h`, once.
  std::string Version() const;
  // Whether it was built with CUDA (without, patch_match_stereo refuses to run).
  bool HasCuda() const;

  // Runs `colmap arguments...` and waits. Everything that it prints goes to `log_path` (replaced;
  // the folder is made), and nothing to our own output. On cancel the process and its children are
  // stopped and CancelledError is thrown. Throws ExternalToolError if the executable is missing,
  // cannot be started, dies or returns other than 0: the message quotes the last lines of the log
  // and names it.
  ToolUsage Run(const std::vector<std::string>& arguments, const std::filesystem::path& log_path,
                const RunContext& context) const;

  // Whether `colmap help` lists a command of this name; runs it.
  bool HasCommand(const std::string& name) const;

 private:
  const std::string& Banner() const;

  std::filesystem::path executable_;
  mutable std::optional<std::string> banner_;
};

}  // namespace lsmvs
