#include "lsmvs/util/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>
#include <vector>

#include "lsmvs/util/error.h"

namespace lsmvs {

struct Hasher::State {
  XXH3_state_t* xxh = XXH3_createState();
  ~State() { XXH3_freeState(xxh); }
};

Hasher::Hasher() : state_(std::make_unique<State>()) { XXH3_128bits_reset(state_->xxh); }
Hasher::~Hasher() = default;

Hasher& Hasher::Update(const void* data, size_t num_bytes) {
  XXH3_128bits_update(state_->xxh, data, num_bytes);
  return *this;
}

Hasher& Hasher::Update(std::string_view text) {
  const uint64_t length = text.size();
  Update(&length, sizeof length);
  return Update(text.data(), text.size());
}

std::string Hasher::HexDigest() const {
  const XXH128_hash_t digest = XXH3_128bits_digest(state_->xxh);
  return fmt::format("{:016x}{:016x}", digest.high64, digest.low64);
}

std::string HashFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), "cannot be opened", "check that it exists");
  Hasher hasher;
  std::vector<char> buffer(size_t{1} << 20);
  while (file) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    hasher.Update(buffer.data(), static_cast<size_t>(file.gcount()));
  }
  if (file.bad()) throw InputError(path.string(), "cannot be read", "check the disk");
  return hasher.HexDigest();
}

}  // namespace lsmvs
