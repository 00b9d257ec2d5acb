#include "fuzz_input.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "lsmvs/util/error.h"

namespace lsmvs::fuzz {

namespace {

struct MemoryFolder {
  MemoryFolder() {
    std::string name = "/dev/shm/lsmvs-fuzz-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) ::abort();
    path = name;
  }
  ~MemoryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  std::filesystem::path path;
};

}  // namespace

std::string_view FuzzInput::NextPiece() {
  uint16_t length = 0;
  if (bytes_.size() >= sizeof length) {
    std::memcpy(&length, bytes_.data(), sizeof length);
    bytes_.remove_prefix(sizeof length);
  }
  const std::string_view piece = bytes_.substr(0, length);
  bytes_.remove_prefix(piece.size());
  return piece;
}

const std::filesystem::path& Folder() {
  static const MemoryFolder folder;
  return folder.path;
}

std::filesystem::path PutFile(const char* name, std::string_view bytes) {
  const std::filesystem::path path = Folder() / name;
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const auto written = ::write(descriptor, bytes.data(), bytes.size());
  if (descriptor < 0 || written != static_cast<ssize_t>(bytes.size())) ::abort();
  ::close(descriptor);
  return path;
}

void ExpectInputErrorAtMost(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError&) {
  }
}

}  // namespace lsmvs::fuzz
