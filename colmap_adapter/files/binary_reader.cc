#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "lsmvs/colmap_adapter/files/binary_reader.h"
#include "lsmvs/util/error.h"

namespace lsmvs::internal {

namespace {
constexpr size_t kBufferBytes = size_t{1} << 18;
}

BinaryReader::BinaryReader(const std::filesystem::path& path, std::string remedy)
    : path_(path.string()), remedy_(std::move(remedy)) {
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) {
    const int error = errno;
    throw InputError(path_, fmt::format("cannot be opened: {}", std::strerror(error)), remedy_);
  }
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw InputError(path_, "is not a regular file", remedy_);
  }
  size_ = static_cast<uint64_t>(status.st_size);
  buffer_.resize(static_cast<size_t>(std::clamp<uint64_t>(size_, 1, kBufferBytes)));
}

BinaryReader::~BinaryReader() { ::close(descriptor_); }

void BinaryReader::FailAt(const std::string& what, uint64_t position) const {
  throw InputError(path_, what, remedy_, position);
}

void BinaryReader::Refill() {
  buffer_position_ += filled_;
  next_ = filled_ = 0;
  ssize_t count = 0;
  do {
    count = ::read(descriptor_, buffer_.data(), buffer_.size());
  } while (count < 0 && errno == EINTR);
  if (count < 0) Fail(fmt::format("cannot be read: {}", std::strerror(errno)));
  if (count == 0) Fail("ends too early");
  filled_ = static_cast<size_t>(count);
}

void BinaryReader::ReadBytes(void* out, size_t num_bytes) {
  if (num_bytes > Remaining()) FailAt("ends too early", size_);
  char* target = static_cast<char*>(out);
  while (num_bytes > 0) {
    if (next_ == filled_) Refill();
    const size_t part = std::min(num_bytes, filled_ - next_);
    std::memcpy(target, buffer_.data() + next_, part);
    next_ += part;
    target += part;
    num_bytes -= part;
  }
}

void BinaryReader::Skip(uint64_t num_bytes) {
  if (num_bytes > Remaining()) FailAt("ends too early", size_);
  while (num_bytes > 0) {
    if (next_ == filled_) Refill();
    const uint64_t part = std::min<uint64_t>(num_bytes, filled_ - next_);
    next_ += static_cast<size_t>(part);
    num_bytes -= part;
  }
}

std::string BinaryReader::ReadNulTerminated(size_t max_length) {
  const uint64_t position = Position();
  std::string text;
  for (char c = Read<char>(); c != '\0'; c = Read<char>()) {
    if (text.size() == max_length) FailAt("has a name that does not end", position);
    text.push_back(c);
  }
  return text;
}

void BinaryReader::ExpectEnd() {
  if (Remaining() > 0) Fail(fmt::format("has {} bytes more than it should", Remaining()));
}

void BinaryReader::CheckCount(uint64_t count, size_t min_record_bytes, const char* what,
                              uint64_t position) const {
  if (count > Remaining() / min_record_bytes) {
    FailAt(fmt::format("claims {} {}, more than its size allows", count, what), position);
  }
}

}  // namespace lsmvs::internal
