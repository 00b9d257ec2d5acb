#include "lsmvs/util/error.h"

#include <fmt/format.h>

#include <cstring>

namespace lsmvs {

namespace {
std::string InputMessage(const std::string& path, const std::string& what,
                         const std::string& remedy, std::optional<uint64_t> byte_offset) {
  std::string message = fmt::format("{}: {}", path, what);
  if (byte_offset) message += fmt::format(" (at byte {})", *byte_offset);
  if (!remedy.empty()) message += "; " + remedy;
  return message;
}
}  // namespace

InputError::InputError(const std::string& path, const std::string& what, const std::string& remedy,
                       std::optional<uint64_t> byte_offset)
    : Error(ExitCode::kBadInput, InputMessage(path, what, remedy, byte_offset)) {}

FileSystemError::FileSystemError(const std::string& path, const std::string& action,
                                 int error_number)
    : Error(ExitCode::kFileSystem,
            fmt::format("{}: cannot {}: {}; check permissions and free space", path, action,
                        std::strerror(error_number))) {}

}  // namespace lsmvs
