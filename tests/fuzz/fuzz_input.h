#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

namespace lsmvs::fuzz {

// Bytes from the fuzzer, handed out in pieces.
class FuzzInput {
 public:
  FuzzInput(const uint8_t* data, size_t size) : bytes_(reinterpret_cast<const char*>(data), size) {}

  // The next piece of an input that holds several files: its length as 16 bits, then its bytes.
  std::string_view NextPiece();
  std::string_view Rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

// A folder in memory that lasts as long as the program.
const std::filesystem::path& Folder();
// Puts bytes into a file of Folder() (sub-folders must exist); returns its path.
std::filesystem::path PutFile(const char* name, std::string_view bytes);

// Runs a reader. InputError is what bad input should end in; anything else ends the program, as a
// finding.
void ExpectInputErrorAtMost(const std::function<void()>& read);

}  // namespace lsmvs::fuzz
