#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lsmvs {

// One problem of patch-match.cfg: a reference image and where its source images come from.
struct PatchMatchProblem {
  enum class Sources {
    kAuto,    // the `max_num_sources` best by shared points ("__auto__, 20")
    kAll,     // every other image ("__all__")
    kListed,  // `source_names`
  };
  std::string reference_name;
  Sources sources = Sources::kAuto;
  int max_num_sources = 20;
  std::vector<std::string> source_names;
};

// Reads patch-match.cfg: pairs of lines; comments (#) and blank lines are skipped. Throws
// InputError with the line. Names are not compared with any model.
std::vector<PatchMatchProblem> ReadPatchMatchConfig(const std::filesystem::path& path);
void WritePatchMatchConfig(const std::filesystem::path& path,
                           const std::vector<PatchMatchProblem>& problems);

// fusion.cfg: the names of the images whose maps are fused, one a line.
std::vector<std::string> ReadFusionConfig(const std::filesystem::path& path);
void WriteFusionConfig(const std::filesystem::path& path, const std::vector<std::string>& names);

}  // namespace lsmvs
