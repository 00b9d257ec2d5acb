#include "lsmvs/util/unnamed_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

// Calls call(bytes done) until all are; false if it fails.
template <class Call>
bool TransferAll(size_t count, const Call& call) {
  for (size_t done = 0; done < count;) {
    const ssize_t moved = call(done);
    if (moved < 0 && errno == EINTR) continue;
    if (moved == 0) errno = EIO;
    if (moved <= 0) return false;
    done += static_cast<size_t>(moved);
  }
  return true;
}

}  // namespace

std::filesystem::path FolderForTemporaryFiles() {
  const char* folder = std::getenv("TMPDIR");
  return folder != nullptr && *folder != '\0' ? folder : "/tmp";
}

int OpenUnnamedFile(const std::filesystem::path& folder) {
#ifdef O_TMPFILE
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0) return file;
#endif
  std::string name = (folder / "lsmvs-scratch-XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named < 0) throw FileSystemError(folder.string(), "make a scratch file there", errno);
  ::unlink(name.c_str());
  return named;
}

UnnamedFile::UnnamedFile(const std::filesystem::path& folder)
    : folder_(folder), file_(OpenUnnamedFile(folder)) {}

UnnamedFile::~UnnamedFile() { ::close(file_); }

void UnnamedFile::Write(uint64_t offset, const void* bytes, size_t count) {
  const bool done = TransferAll(count, [&](size_t at) {
    return ::pwrite(file_, static_cast<const char*>(bytes) + at, count - at,
                    static_cast<off_t>(offset + at));
  });
  if (!done) throw FileSystemError(folder_.string(), "write to a scratch file there", errno);
}

void UnnamedFile::Read(uint64_t offset, void* bytes, size_t count) const {
  const bool done = TransferAll(count, [&](size_t at) {
    return ::pread(file_, static_cast<char*>(bytes) + at, count - at,
                   static_cast<off_t>(offset + at));
  });
  if (!done) throw FileSystemError(folder_.string(), "read from a scratch file there", errno);
}

}  // namespace lsmvs
