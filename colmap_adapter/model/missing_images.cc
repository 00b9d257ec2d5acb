#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <cctype>

#include "lsmvs/colmap_adapter/model/missing_images.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

constexpr size_t kNamesListed = 5;

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// As far as two names may differ and still mean the same image: case and kind of slash.
std::string Normalized(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return Lower(fs::path(name).lexically_normal().generic_string());
}

std::string WithoutExtension(const std::string& name) {
  return fs::path(name).replace_extension().generic_string();
}

// Names of all files below the folder, relative to it.
std::vector<std::string> FilesBelow(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    if (entry.is_regular_file()) {
      names.push_back(entry.path().lexically_relative(folder).generic_string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

// The file that is most likely meant by a name; empty if none is.
std::string SimilarFile(const std::string& name, const std::vector<std::string>& files) {
  const std::string wanted = Normalized(name);
  const auto same = [&](const std::string& file) { return Normalized(file) == wanted; };
  const auto same_stem = [&](const std::string& file) {
    return WithoutExtension(Normalized(file)) == WithoutExtension(wanted);
  };
  auto found = std::find_if(files.begin(), files.end(), same);
  if (found == files.end()) found = std::find_if(files.begin(), files.end(), same_stem);
  return found == files.end() ? "" : *found;
}

}  // namespace

std::string MissingImages::Describe() const {
  std::string text = names_.size() == num_images_
                         ? fmt::format("holds none of the model's {} photos: ", num_images_)
                         : fmt::format("{} of the model's {} photos {} missing: ", names_.size(),
                                       num_images_, names_.size() == 1 ? "is" : "are");
  const std::vector<std::string> files = FilesBelow(folder_);
  for (size_t i = 0; i < std::min(names_.size(), kNamesListed); ++i) {
    const std::string similar = SimilarFile(names_[i], files);
    text += fmt::format("{}{}{}", i == 0 ? "" : ", ", names_[i],
                        similar.empty() ? "" : " (there is " + similar + ")");
  }
  if (names_.size() > kNamesListed) text += ", ...";
  return text;
}

void MissingImages::Throw() const {
  throw InputError(
      folder_.string(), Describe(),
      fmt::format("give them these names, put them back, {}name their folder with --image_path if "
                  "this is a project",
                  LeavesEnough() ? "go on without them by --skip_missing_images, or " : "or "));
}

void MissingImages::Warn() const {
  LOG(WARNING) << folder_.string() << ": " << Describe() << "; the work goes on without them";
}

}  // namespace lsmvs
