#include "lsmvs/colmap_adapter/cloud_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

struct HashedInput {
  std::string cloud_hash, model_hash;
  std::string name;  // as it was given
  CloudInput input;

  auto Content() const { return std::tie(model_hash, cloud_hash); }
};

std::string HashFiles(const std::vector<fs::path>& files) {
  Hasher hasher;
  for (const fs::path& file : files) hasher.Update(HashFile(file));
  return hasher.HexDigest();
}

HashedInput HashInput(const std::string& path, bool sparse) {
  HashedInput hashed{{}, {}, path, FindCloudInput(path)};
  const DenseWorkspace& workspace = hashed.input.workspace;
  const fs::path model = workspace.SparseFolder();
  if (!IsSparseModelFolder(model)) {
    throw InputError(model.string(), DescribeMissingModel(model),
                     "name the workspace whose cameras see the cloud");
  }
  hashed.model_hash = HashFiles(workspace.ModelFiles());
  if (!sparse) {
    const fs::path& cloud = hashed.input.cloud;
    for (const fs::path& file : {cloud, DenseWorkspace::VisibilityPath(cloud)}) {
      if (!fs::exists(file)) {
        throw InputError(file.string(), "is missing",
                         "make it with `lsmvs-mesher " + workspace.folder.string() +
                             " --to stereo_fusion`, or correct --input_path");
      }
    }
    hashed.cloud_hash = HashFiles({cloud, DenseWorkspace::VisibilityPath(cloud)});
  }
  return hashed;
}

// The same points count once, also where the poses were written again.
void RefuseTheSamePoints(const std::vector<HashedInput>& inputs, bool sparse) {
  const auto points = [&](const HashedInput& input) -> const std::string& {
    return sparse ? input.model_hash : input.cloud_hash;
  };
  std::map<std::string, std::string> names;
  for (const HashedInput& input : inputs) {
    const auto [it, is_new] = names.emplace(points(input), input.name);
    if (is_new) continue;
    throw UsageError(fmt::format(
        "--input_path is given twice for the same {}: {} and {}; each point may count once, leave "
        "one out",
        sparse ? "model" : "cloud", std::min(it->second, input.name),
        std::max(it->second, input.name)));
  }
}

bool HasPlyName(const fs::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".ply" || extension == ".PLY";
}

}  // namespace

CloudInput FindCloudInput(const std::string& path) {
  if (!fs::exists(path)) {
    throw InputError(path, "does not exist", "name a workspace, or a cloud in one");
  }
  if (fs::is_directory(path)) {
    const DenseWorkspace workspace{path};
    return {workspace, workspace.FusedPath()};
  }
  if (!HasPlyName(path)) {
    throw InputError(path, "is neither a folder nor a PLY file",
                     "name a workspace, or a cloud in one");
  }
  const fs::path folder = fs::path(path).parent_path();
  return {DenseWorkspace{folder.empty() ? fs::path(".") : folder}, path};
}

std::vector<CloudInput> FindCloudInputs(const std::vector<std::string>& paths, bool sparse) {
  std::vector<HashedInput> hashed;
  for (const std::string& path : paths) hashed.push_back(HashInput(path, sparse));
  std::stable_sort(hashed.begin(), hashed.end(), [](const HashedInput& a, const HashedInput& b) {
    return a.Content() < b.Content();
  });
  RefuseTheSamePoints(hashed, sparse);
  std::vector<CloudInput> inputs;
  size_t num_models = 0;
  for (size_t i = 0; i < hashed.size(); ++i) {
    num_models += (i == 0 || hashed[i].model_hash != hashed[i - 1].model_hash);
    inputs.push_back(std::move(hashed[i].input));
    inputs.back().model_idx = num_models - 1;
  }
  return inputs;
}

std::string ViewNumbersText(const std::vector<CloudInput>& inputs,
                            const std::vector<Scene>& parts) {
  std::string text;
  int first = 0;
  const std::vector<DenseWorkspace> workspaces = WorkspacesOfModels(inputs);
  for (size_t i = 0; i < workspaces.size(); ++i) {
    const int end = first + parts[i].num_views();
    text += fmt::format("views {} to {}: {}\n", first, end - 1, workspaces[i].folder.string());
    first = end;
  }
  return text;
}

}  // namespace lsmvs
