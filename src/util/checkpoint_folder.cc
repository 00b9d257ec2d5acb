#include "lsmvs/util/checkpoint_folder.h"

#include <algorithm>
#include <cstring>
#include <fstream>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {
constexpr const char* kFinished = ".finished";
}

bool CheckpointFolder::HasFinished(const std::string& step) const {
  return is_on() && std::filesystem::exists(PathOf(step + kFinished));
}

void CheckpointFolder::FinishStep(const std::string& step) const {
  if (is_on()) WriteFileAtomically(PathOf(step + kFinished), "");
}

void CheckpointFolder::WriteBytes(const std::string& name, const void* data,
                                  size_t num_bytes) const {
  if (!is_on()) return;
  AtomicFile file(PathOf(name));
  file.Write(data, num_bytes);
  file.Commit();
}

void CheckpointFolder::ReadBytes(const std::string& name, size_t value_size,
                                 const std::function<char*(size_t num_values)>& make_room) const {
  const std::filesystem::path path = PathOf(name);
  const auto fail = [&](const char* what) {
    throw InputError(path.string(), what, "remove its folder, and start again");
  };
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("cannot be opened");
  const auto num_bytes = static_cast<size_t>(std::filesystem::file_size(path));
  if (num_bytes % value_size != 0) fail("is cut off");
  char* to = make_room(num_bytes / value_size);
  // In pieces: a system call cannot write to scratch memory.
  std::vector<char> piece(std::min<size_t>(num_bytes, size_t{1} << 20));
  for (size_t done = 0; done < num_bytes;) {
    const size_t size = std::min(piece.size(), num_bytes - done);
    if (!file.read(piece.data(), static_cast<std::streamsize>(size))) fail("is cut off");
    std::memcpy(to + done, piece.data(), size);
    done += size;
  }
}

}  // namespace lsmvs
