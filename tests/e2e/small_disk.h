#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {

// A file system of its own, of a given size ("20m"), as long as the object lives.
class SmallDisk {
 public:
  explicit SmallDisk(const std::string& size);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  // False where the tests may not mount; then `reason` says why.
  bool mounted() const { return mounted_; }
  const std::string& reason() const { return reason_; }
  std::filesystem::path path() const { return folder_.path(); }
  // A folder that is not there yet.
  std::filesystem::path workspace() const { return folder_.path() / "w"; }
  void MakeReadOnly() const;

 private:
  TemporaryFolder folder_;
  bool mounted_ = false;
  std::string reason_;
};

}  // namespace lsmvs
