#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace lsmvs {

// 128-bit content hash (XXH3) built up piece by piece; not cryptographic. The same bytes give the
// same hash on every machine and however they are cut into pieces.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;

  Hasher& Update(const void* data, size_t num_bytes);
  // Hashes the length too, so that ("ab","c") and ("a","bc") differ.
  Hasher& Update(std::string_view text);
  // 32 hexadecimal digits.
  std::string HexDigest() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Hash of a file's bytes. Throws InputError when it cannot be read.
std::string HashFile(const std::filesystem::path& path);

}  // namespace lsmvs
