#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {

// A file system of its own, of a given size ("300k", "20m"), as long as the object lives. It takes
// rights that not every machine gives.
class SmallDisk {
 public:
  explicit SmallDisk(const std::string& size);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool mounted() const { return mounted_; }
  const std::string& reason() const { return reason_; }  // why it is not
  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path workspace() const { return folder_.path() / "w"; }
  void MakeReadOnly() const;
  // What lies there stays.
  void Resize(const std::string& size) const;

 private:
  TemporaryFolder folder_;
  bool mounted_ = false;
  std::string reason_;
};

}  // namespace lsmvs
