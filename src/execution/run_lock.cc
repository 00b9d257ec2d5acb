#include "lsmvs/execution/run_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "lsmvs/util/error.h"

namespace lsmvs {

RunLock::RunLock(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  if (error) throw FileSystemError(path.parent_path().string(), "create the folder", error.value());
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0) throw FileSystemError(path.string(), "create the file", errno);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(descriptor_);
    throw Error(ExitCode::kFileSystem,
                path.parent_path().string() +
                    ": another run is at work in this folder; wait for it to end or stop it");
  }
}

RunLock::~RunLock() { ::close(descriptor_); }

}  // namespace lsmvs
