#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "lsmvs/util/error.h"

namespace lsmvs {

// Values one after the other in a string of bytes, for another process of the same program.
class ByteWriter {
 public:
  template <class T>
  ByteWriter& Put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  // `T`: of a fixed size, without pointers.
  template <class T>
  ByteWriter& PutAll(const std::vector<T>& values) {
    bytes_.reserve(bytes_.size() + sizeof(uint64_t) + values.size() * sizeof(T));
    Put(uint64_t{values.size()});
    if (!values.empty()) {
      bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
    return *this;
  }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Takes them out again, in the same order. Throws Error(kInternal) where there are too few bytes.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  T Get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, Next(sizeof value).data(), sizeof value);
    return value;
  }
  template <class T>
  std::vector<T> GetAll() {
    const auto count = Get<uint64_t>();
    if (count > bytes_.size() / sizeof(T)) Fail();
    std::vector<T> values(static_cast<size_t>(count));
    const std::string_view from = Next(values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(static_cast<void*>(values.data()), from.data(), from.size());
    return values;
  }

 private:
  [[noreturn]] static void Fail() {
    throw Error(ExitCode::kInternal, "a message of another process is cut off");
  }
  std::string_view Next(size_t num_bytes) {
    if (num_bytes > bytes_.size()) Fail();
    const std::string_view next = bytes_.substr(0, num_bytes);
    bytes_.remove_prefix(num_bytes);
    return next;
  }

  std::string_view bytes_;
};

}  // namespace lsmvs
