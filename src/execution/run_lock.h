#pragma once

#include <filesystem>

namespace lsmvs {

// Keeps a second run out of a folder, as long as it lives. The kernel frees it when the process
// ends, however it ends.
class RunLock {
 public:
  // Makes `path` (and its folder) if it is missing. Throws FileSystemError if it cannot,
  // Error(kFileSystem) if another process holds the lock. File systems that know no locks are taken
  // as free.
  explicit RunLock(const std::filesystem::path& path);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace lsmvs
