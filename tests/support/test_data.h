#pragma once

#include <filesystem>
#include <string>

namespace lsmvs {

// Folder of the real and rendered scenes: $LSMVS_DATA_DIR, or ../shared/data beside the source
// tree. Empty if neither is there.
std::filesystem::path TestDataFolder();

// The folder that the built programs lie in.
std::filesystem::path ProgramFolder();

// Text that says which scene is missing and where it was looked for, or empty if `scene` is there.
std::string MissingScene(const std::string& scene);

}  // namespace lsmvs

// Skips the test, and says why, where the scene data are not installed (a user's machine).
#define LSMVS_REQUIRE_SCENE(scene)                                                  \
  do {                                                                              \
    if (const std::string missing = ::lsmvs::MissingScene(scene); !missing.empty()) \
      GTEST_SKIP() << missing;                                                      \
  } while (false)
