#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {

// A dense workspace with five photos of 128 x 96 of a relief wall, small enough that a whole run
// takes a second or two. Rendered once a process, copied for each object, removed with it.
class SmallWorkspace {
 public:
  SmallWorkspace();

  const std::filesystem::path& path() const { return path_; }
  std::string text() const { return path_.string(); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  TemporaryFolder folder_;
  std::filesystem::path path_;
};

// Contents of all files below the folder that a run may leave, by relative name, but for the record
// of runs (it holds times).
std::map<std::string, std::string> ReadResults(const std::filesystem::path& folder);

// Names of files that a run must not leave: temporary or staged ones.
std::vector<std::string> FindLeftovers(const std::filesystem::path& folder);

// The same bytes in a new file of another time, or one byte sequence replaced at an offset.
void OverwriteBytes(const std::filesystem::path& path, size_t offset, const std::string& bytes);
void WriteText(const std::filesystem::path& path, const std::string& text);
std::string ReadText(const std::filesystem::path& path);

}  // namespace lsmvs
