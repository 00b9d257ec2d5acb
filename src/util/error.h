#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace lsmvs {

// Exit codes of every program. They are documented in `lsmvs --help` and README.md.
enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,      // a bug: a check failed, or an exception that nobody foresaw
  kUsage = 2,         // unknown option, value out of range
  kBadInput = 3,      // a file of the user is missing, corrupt or inconsistent
  kFileSystem = 4,    // cannot write: read-only, full, no permission
  kMemory = 5,        // the work does not fit the memory budget
  kOverwrite = 6,     // would overwrite a file that we did not make
  kExternalTool = 7,  // the `colmap` executable or the job system is missing or failed
  kCancelled = 130,   // Ctrl-C or SIGTERM; finished stages are kept
};

// Base of all errors that a user can cause or meet. what() is one line that names the file (if
// any), what is wrong and what to do. `main` prints it and exits with code().
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

// A file or folder of the user is missing, corrupt, or does not fit the others.
class InputError : public Error {
 public:
  // Message: "<path>: <what> (at byte <offset>); <remedy>".
  InputError(const std::string& path, const std::string& what, const std::string& remedy,
             std::optional<uint64_t> byte_offset = std::nullopt);
};

// An option has a value that cannot be used, or options contradict each other.
class UsageError : public Error {
 public:
  explicit UsageError(const std::string& message) : Error(ExitCode::kUsage, message) {}
};

// A file cannot be written; names the path and the system's reason.
class FileSystemError : public Error {
 public:
  // Takes the reason from `error_number` (an errno).
  FileSystemError(const std::string& path, const std::string& action, int error_number);
};

// The work would not fit into the memory budget; says what would.
class MemoryError : public Error {
 public:
  explicit MemoryError(const std::string& message) : Error(ExitCode::kMemory, message) {}
};

// Somebody asked to stop. Nothing half-written is left.
class CancelledError : public Error {
 public:
  CancelledError() : Error(ExitCode::kCancelled, "cancelled; finished stages are kept") {}
};

}  // namespace lsmvs
