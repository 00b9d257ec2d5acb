#include "lsmvs/util/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {
constexpr size_t kBufferBytes = size_t{1} << 20;
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  temporary_path_ = path_;
  temporary_path_ += kTemporarySuffix;
  if (path_.has_parent_path()) {
    std::error_code error;
    std::filesystem::create_directories(path_.parent_path(), error);
    if (error) {
      throw FileSystemError(path_.parent_path().string(), "create the folder", error.value());
    }
  }
  descriptor_ = ::open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) throw FileSystemError(path_.string(), "create the file", errno);
  buffer_.reserve(kBufferBytes);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(temporary_path_.c_str());
}

void AtomicFile::Write(const void* data, size_t num_bytes) {
  const char* bytes = static_cast<const char*>(data);
  // In pieces: a system call cannot read scratch memory.
  while (num_bytes > 0) {
    if (buffer_.size() == kBufferBytes) Flush();
    const size_t piece = std::min(num_bytes, kBufferBytes - buffer_.size());
    buffer_.insert(buffer_.end(), bytes, bytes + piece);
    bytes += piece;
    num_bytes -= piece;
  }
}

void AtomicFile::Flush() {
  WriteThrough(buffer_.data(), buffer_.size());
  buffer_.clear();
}

void AtomicFile::WriteThrough(const char* data, size_t num_bytes) {
  while (num_bytes > 0) {
    const ssize_t written = ::write(descriptor_, data, num_bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw FileSystemError(path_.string(), "write", errno);
    data += written;
    num_bytes -= static_cast<size_t>(written);
  }
}

void AtomicFile::WriteContentOf(const std::filesystem::path& source, uint64_t offset) {
  std::ifstream file(source, std::ios::binary);
  if (!file) throw InputError(source.string(), "cannot be opened", "check that it exists");
  file.seekg(static_cast<std::streamoff>(offset));
  std::vector<char> piece(kBufferBytes);
  while (file) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    Write(piece.data(), static_cast<size_t>(file.gcount()));
  }
  if (!file.eof()) throw InputError(source.string(), "cannot be read", "check the disk");
}

void AtomicFile::Overwrite(size_t offset, std::string_view bytes) {
  Flush();
  while (!bytes.empty()) {
    const ssize_t written =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw FileSystemError(path_.string(), "write", errno);
    bytes.remove_prefix(static_cast<size_t>(written));
    offset += static_cast<size_t>(written);
  }
}

void AtomicFile::Commit() {
  Flush();
  if (::fsync(descriptor_) != 0 && errno != EINVAL) {
    throw FileSystemError(path_.string(), "flush", errno);
  }
  const int descriptor = std::exchange(descriptor_, -1);
  if (::close(descriptor) != 0 || ::rename(temporary_path_.c_str(), path_.c_str()) != 0) {
    const int error_number = errno;
    ::unlink(temporary_path_.c_str());
    throw FileSystemError(path_.string(), "finish the file", error_number);
  }
}

void WriteFileAtomically(const std::filesystem::path& path, std::string_view content) {
  AtomicFile file(path);
  file.Write(content);
  file.Commit();
}

void CopyFileAtomically(const std::filesystem::path& from, const std::filesystem::path& to) {
  AtomicFile file(to);
  file.WriteContentOf(from);
  file.Commit();
}

}  // namespace lsmvs
