#include "lsmvs/test_support/test_data.h"

#include <cstdlib>

namespace lsmvs {

namespace {
std::filesystem::path WantedFolder() {
  if (const char* folder = std::getenv("LSMVS_DATA_DIR"); folder != nullptr) return folder;
  return std::filesystem::path(LSMVS_SOURCE_DIR).parent_path() / "shared" / "data";
}
}  // namespace

std::filesystem::path TestDataFolder() {
  return std::filesystem::is_directory(WantedFolder()) ? WantedFolder() : std::filesystem::path();
}

std::filesystem::path ProgramFolder() { return std::filesystem::path(LSMVS_BINARY_DIR) / "bin"; }

std::string MissingScene(const std::string& scene) {
  const std::filesystem::path folder = WantedFolder() / scene;
  if (std::filesystem::is_directory(folder)) return "";
  return "scene " + scene + " is not at " + folder.string() +
         "; set LSMVS_DATA_DIR to run this test";
}

}  // namespace lsmvs
