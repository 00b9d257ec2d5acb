#include "lsmvs/cli/commands/evaluation_input.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "lsmvs/cli/nearest_name.h"
#include "lsmvs/colmap_adapter/pmvs_cloud.h"
#include "lsmvs/colmap_adapter/pmvs_scene.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/util/error.h"

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

std::vector<int> FindViews(const Scene& scene, const std::string& names) {
  std::vector<int> view_idxs;
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) {
    view_idxs.push_back(FindView(scene, name));
  }
  std::sort(view_idxs.begin(), view_idxs.end());
  view_idxs.erase(std::unique(view_idxs.begin(), view_idxs.end()), view_idxs.end());
  return view_idxs;
}

Eigen::Vector3d UpDirection(const std::vector<View>& views) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const View& view : views) sum -= view.cam_from_world.rotation.row(1);
  return sum.norm() > 1e-3 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d(0, -1, 0);
}

int MostRevealingView(const Scene& scene) {
  if (scene.views.empty()) return -1;
  std::vector<int> counts(scene.views.size(), 0);
  for (const SparsePoint& point : scene.points) {
    for (const int view : point.view_idxs) ++counts[view];
  }
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

PosedCamera ViewpointOf(const View& view, int width) {
  const double scale = static_cast<double>(width) / view.camera.width;
  const int height = std::max(1, static_cast<int>(std::lround(view.camera.height * scale)));
  return {view.camera.Resized(width, height), view.cam_from_world};
}

std::vector<Eigen::Vector3d> CentralVertices(const TriangleMesh& mesh, const Scene& scene) {
  if (scene.points.empty()) return mesh.vertices;
  Eigen::AlignedBox3d box;
  std::vector<double> values(scene.points.size());
  const size_t cut = values.size() / 25;
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < values.size(); ++i) values[i] = scene.points[i].x_in_world[axis];
    std::sort(values.begin(), values.end());
    const double margin = 0.125 * (values[values.size() - 1 - cut] - values[cut]);
    box.min()[axis] = values[cut] - margin;
    box.max()[axis] = values[values.size() - 1 - cut] + margin;
  }
  std::vector<Eigen::Vector3d> central;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    if (box.contains(x)) central.push_back(x);
  }
  return central.size() > mesh.vertices.size() / 20 ? central : mesh.vertices;
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

TurntableOptions TurntableBefore(const std::vector<Eigen::Vector3d>& points,
                                 const std::vector<View>& views) {
  TurntableOptions options;
  options.up = UpDirection(views);
  options.fit_share = 0.98;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), cameras = Eigen::Vector3d::Zero();
  size_t count = 0;
  for (const Eigen::Vector3d& x : points) {
    if (!x.allFinite()) continue;
    middle += x;
    ++count;
  }
  for (const View& view : views) cameras += view.CenterInWorld();
  if (count == 0 || views.empty()) return options;
  options.front = cameras / static_cast<double>(views.size()) - middle / static_cast<double>(count);
  return options;
}

}  // namespace lsmvs
