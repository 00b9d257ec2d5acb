#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

namespace lsmvs::internal {

// Reads a little-endian binary file front to back. Knows the size of the file, so that no count in
// it is believed that the remaining bytes cannot hold. Every failure throws InputError with path
// and byte.
class BinaryReader {
 public:
  // `remedy` ends the messages.
  BinaryReader(const std::filesystem::path& path, std::string remedy);
  ~BinaryReader();
  BinaryReader(const BinaryReader&) = delete;
  BinaryReader& operator=(const BinaryReader&) = delete;

  uint64_t size() const { return size_; }
  uint64_t Position() const { return buffer_position_ + next_; }
  uint64_t Remaining() const { return size_ - Position(); }

  void ReadBytes(void* out, size_t num_bytes);
  void Skip(uint64_t num_bytes);

  template <class T>
  T Read() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    ReadBytes(&value, sizeof value);
    return value;
  }
  // Reads a count of type T of records that take at least `min_record_bytes` each.
  template <class T>
  uint64_t ReadCount(size_t min_record_bytes, const char* what) {
    const uint64_t position = Position();
    const T count = Read<T>();
    CheckCount(static_cast<uint64_t>(count), min_record_bytes, what, position);
    return static_cast<uint64_t>(count);
  }
  // Bytes up to a NUL, which is consumed.
  std::string ReadNulTerminated(size_t max_length);
  // Throws unless everything was read.
  void ExpectEnd();

  [[noreturn]] void Fail(const std::string& what) const { FailAt(what, Position()); }
  [[noreturn]] void FailAt(const std::string& what, uint64_t position) const;

 private:
  void Refill();
  void CheckCount(uint64_t count, size_t min_record_bytes, const char* what,
                  uint64_t position) const;

  std::string path_, remedy_;
  int descriptor_ = -1;
  uint64_t size_ = 0, buffer_position_ = 0;
  std::vector<char> buffer_;
  size_t next_ = 0, filled_ = 0;
};

}  // namespace lsmvs::internal
