#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/source_rules.h"

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
  // Of the file, for messages.
  uint64_t reference_line = 0, source_line = 0;
};

// Reads patch-match.cfg: pairs of lines; comments (#) and blank lines are skipped. Throws
// InputError with the line. Names are not compared with any model: ToSourceRules does that.
std::vector<PatchMatchProblem> ReadPatchMatchConfig(const std::filesystem::path& path);

// Whether they are what image_undistorter writes, "__auto__, 20" for each image, which says
// nothing: photos may have been renamed since.
bool AreColmapsDefault(const std::vector<PatchMatchProblem>& problems);

// What the problems say of the scene's views, for ApplySourceRules; views that are no problem's
// reference get no neighbours. Throws InputError, with line and name, for a name that is no photo
// of the scene, and for a reference that comes twice. `path` is for messages.
std::vector<SourceRule> ToSourceRules(const std::vector<PatchMatchProblem>& problems,
                                      const Scene& scene, const std::filesystem::path& path);

void WritePatchMatchConfig(const std::filesystem::path& path,
                           const std::vector<PatchMatchProblem>& problems);

// fusion.cfg: the names of the images whose maps are fused, one a line.
std::vector<std::string> ReadFusionConfig(const std::filesystem::path& path);
void WriteFusionConfig(const std::filesystem::path& path, const std::vector<std::string>& names);

}  // namespace lsmvs
