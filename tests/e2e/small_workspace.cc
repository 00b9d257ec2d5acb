#include "small_workspace.h"

#include <fstream>
#include <sstream>

#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/util/atomic_file.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

const fs::path& Rendered() {
  static const TemporaryFolder folder;
  static const bool done = [] {
    SyntheticSceneOptions options;
    options.shape = ShapeName::kRelief;
    options.num_views = 5;
    options.width = 128;
    options.height = 96;
    options.num_sparse_points = 500;
    const RunContext context(1);
    SyntheticScene scene = MakeScene(options, context);
    WriteWorkspace(folder.path(), WorkspaceFormat::kDense, &scene, context);
    return true;
  }();
  (void)done;
  return folder.path();
}

}  // namespace

SmallWorkspace::SmallWorkspace() : path_(folder_.path() / "w") {
  fs::copy(Rendered(), path_, fs::copy_options::recursive);
}

std::map<std::string, std::string> ReadResults(const fs::path& folder) {
  std::map<std::string, std::string> results;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (entry.is_regular_file() && name != "lsmvs/run.json") results[name] = ReadText(entry.path());
  }
  return results;
}

std::vector<std::string> FindLeftovers(const fs::path& folder) {
  std::vector<std::string> leftovers;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (name.ends_with(AtomicFile::kTemporarySuffix) || name.find("staging") != std::string::npos) {
      leftovers.push_back(name);
    }
  }
  return leftovers;
}

void OverwriteBytes(const fs::path& path, size_t offset, const std::string& bytes) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(offset));
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void WriteText(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace lsmvs
