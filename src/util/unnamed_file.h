#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace lsmvs {

// TMPDIR, or /tmp. Not std::filesystem's, which throws where there is no such folder.
std::filesystem::path FolderForTemporaryFiles();

// Opens a file without a name in `folder` for reading and writing: it is gone when it is closed,
// however the process ends. Returns the descriptor. Throws FileSystemError.
int OpenUnnamedFile(const std::filesystem::path& folder);

// Bytes that are put aside in such a file.
class UnnamedFile {
 public:
  explicit UnnamedFile(const std::filesystem::path& folder);
  ~UnnamedFile();
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;

  // All of the bytes, or FileSystemError. Thread-safe for parts that do not overlap.
  void Write(uint64_t offset, const void* bytes, size_t count);
  void Read(uint64_t offset, void* bytes, size_t count) const;

 private:
  const std::filesystem::path folder_;
  const int file_;
};

}  // namespace lsmvs
