#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lsmvs {

// Results of finished steps of a long task, in a folder of their own, so that the next start after
// a kill goes on behind them. Arrays are files, each whole or not at all; a step is finished once
// FinishStep has returned: what it wrote before is then complete. Whoever names the folder sees to
// it that it belongs to the same inputs, options and version. Without a folder nothing is kept and
// nothing is found.
class CheckpointFolder {
 public:
  CheckpointFolder() = default;
  explicit CheckpointFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  bool is_on() const { return !folder_.empty(); }
  bool HasFinished(const std::string& step) const;
  bool Has(const std::string& name) const {
    return is_on() && std::filesystem::exists(PathOf(name));
  }
  void FinishStep(const std::string& step) const;

  // Throws FileSystemError. `T` is written as its bytes: by the same program on the same machine.
  template <class T>
  void Write(const std::string& name, const std::vector<T>& values) const {
    WriteBytes(name, values.data(), values.size() * sizeof(T));
  }
  // The values, in an array that is not larger than they are. Throws InputError if it is not there
  // whole.
  template <class T>
  void Read(const std::string& name, std::vector<T>* values) const {
    values->clear();
    ReadBytes(name, sizeof(T), [&](size_t num_values) {
      values->resize(num_values);
      return reinterpret_cast<char*>(values->data());
    });
  }

 private:
  std::filesystem::path PathOf(const std::string& name) const { return folder_ / name; }
  void WriteBytes(const std::string& name, const void* data, size_t num_bytes) const;
  void ReadBytes(const std::string& name, size_t value_size,
                 const std::function<char*(size_t num_values)>& make_room) const;

  std::filesystem::path folder_;
};

}  // namespace lsmvs
