#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lsmvs {

// Images of a model that are not in their folder, and what to tell the user about them.
class MissingImages {
 public:
  // `names` of `num_images`, at least one.
  MissingImages(std::filesystem::path folder, std::vector<std::string> names, size_t num_images)
      : folder_(std::move(folder)), names_(std::move(names)), num_images_(num_images) {}

  // Whether a surface could be made from the others.
  bool LeavesEnough() const { return num_images_ - names_.size() >= 2; }
  // Throws InputError that counts and names them, and tells which are there under a name that
  // differs in case, in the kind of slash or in the extension.
  [[noreturn]] void Throw() const;
  // Logs that the work goes on without them.
  void Warn() const;

 private:
  std::string Describe() const;

  const std::filesystem::path folder_;
  const std::vector<std::string> names_;
  const size_t num_images_;
};

}  // namespace lsmvs
