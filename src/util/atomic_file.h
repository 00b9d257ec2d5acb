#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <type_traits>
#include <vector>

namespace lsmvs {

// A file that appears whole or not at all: bytes go to a temporary name in the same folder;
// Commit() flushes them to the disk and renames. Without Commit() (an exception, a cancel) the
// temporary file is removed and what stood at `path` before stays as it was. A killed process can
// leave the temporary file behind: its name ends in kTemporarySuffix and the next writer of the
// same path replaces it. Every failure throws FileSystemError with the path and the system's
// reason.
class AtomicFile {
 public:
  static constexpr std::string_view kTemporarySuffix = ".lsmvs-tmp";

  // Creates the folder of `path` if it is missing.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void Write(const void* data, size_t num_bytes);
  void Write(std::string_view text) { Write(text.data(), text.size()); }
  // Writes the value's bytes (little endian: the only byte order we run on).
  template <class T>
  void WriteValue(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Write(&value, sizeof value);
  }
  // Writes the bytes of another file from `offset` on, piece by piece. Throws InputError if it
  // cannot be read.
  void WriteContentOf(const std::filesystem::path& source, uint64_t offset = 0);
  // Replaces bytes written before: a count that is known only at the end.
  void Overwrite(size_t offset, std::string_view bytes);
  void Commit();

 private:
  void Flush();
  void WriteThrough(const char* data, size_t num_bytes);

  std::filesystem::path path_, temporary_path_;
  std::vector<char> buffer_;
  int descriptor_ = -1;
};

// Writes a whole file atomically.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view content);

// Copies a file; what stood at `to` is replaced. Throws InputError or FileSystemError.
void CopyFileAtomically(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace lsmvs
