#include "lsmvs/workflow/files/scene_input.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>

#include "lsmvs/colmap_adapter/pmvs_cloud.h"
#include "lsmvs/colmap_adapter/pmvs_scene.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/nearest_name.h"

namespace lsmvs {

namespace {

int FindView(const Scene& scene, const std::string& name) {
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  const std::string nearest = NearestName(name, names);
  throw UsageError(fmt::format("there is no photo '{}'; {}", name,
                               nearest.empty() ? fmt::format("there is '{}'", names.at(0))
                                               : fmt::format("did you mean '{}'?", nearest)));
}

}  // namespace

DenseWorkspace FindWorkspaceToEvaluate(const std::filesystem::path& path) {
  std::vector<DenseWorkspace> found;
  for (const WorkspaceEntry& entry : FindDenseWorkspaces(path)) {
    if (entry.exists) found.push_back(entry.workspace);
  }
  if (found.empty()) return DenseWorkspace{path};
  if (found.size() == 1) return found[0];
  throw UsageError(fmt::format("{} holds {} dense workspaces; give one of them, such as {}",
                               path.string(), found.size(), found[0].folder.string()));
}

Scene LoadSceneToEvaluate(const std::filesystem::path& path, bool check_images) {
  if (IsPmvsFolder(path)) return LoadPmvsScene(path);
  LoadSceneOptions options;
  options.check_images = check_images;
  return LoadScene(FindWorkspaceToEvaluate(path), options);
}

std::optional<Scene> LoadSceneIfGiven(const std::string& path, bool check_images) {
  if (path.empty()) return std::nullopt;
  return LoadSceneToEvaluate(path, check_images);
}

Eigen::Vector3d WorldOffset(const std::optional<Scene>& scene) {
  return scene ? scene->world_offset : Eigen::Vector3d::Zero();
}

std::vector<int> FindViews(const Scene& scene, const std::vector<std::string>& names) {
  std::vector<int> view_idxs;
  for (const std::string& name : names) view_idxs.push_back(FindView(scene, name));
  std::sort(view_idxs.begin(), view_idxs.end());
  view_idxs.erase(std::unique(view_idxs.begin(), view_idxs.end()), view_idxs.end());
  return view_idxs;
}

Eigen::Vector3d ParseDirection(const std::string& option, const std::string& text) {
  Eigen::Vector3d direction;
  char rest = 0;
  const int count = std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &direction.x(), &direction.y(),
                                &direction.z(), &rest);
  if (count != 3 || !direction.allFinite() || direction.norm() == 0) {
    throw UsageError(fmt::format("--{} '{}' must be three numbers such as 0,0,1", option, text));
  }
  return direction.normalized();
}

}  // namespace lsmvs
