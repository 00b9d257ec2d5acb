#pragma once

#include <filesystem>

namespace lsmvs {

// A hidden folder beside `final_folder` that is removed when the work in it does not get to its
// end, and renamed when it does. What an earlier, killed work left there is removed first. Throws
// FileSystemError.
class TemporaryWorkspace {
 public:
  explicit TemporaryWorkspace(const std::filesystem::path& final_folder);
  ~TemporaryWorkspace();
  TemporaryWorkspace(const TemporaryWorkspace&) = delete;
  TemporaryWorkspace& operator=(const TemporaryWorkspace&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  // Replaces the final folder.
  void Keep();

 private:
  const std::filesystem::path final_folder_, folder_;
};

}  // namespace lsmvs
