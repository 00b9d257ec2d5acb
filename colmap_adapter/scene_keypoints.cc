#include "lsmvs/colmap_adapter/scene_keypoints.h"

#include <algorithm>
#include <string>
#include <unordered_map>

#include "lsmvs/colmap_adapter/database.h"

namespace lsmvs {

namespace {

// A sparse point is among the keypoints if one lies this near to its image: what bundle adjustment
// leaves, and far below what lens distortion moves.
constexpr double kMaxErrorPx = 3.0;
constexpr double kMinShareFound = 0.6;
constexpr size_t kMaxChecked = 200;

bool HasNearby(const std::vector<Eigen::Vector2f>& keypoints, const Eigen::Vector2d& x_px) {
  return std::any_of(keypoints.begin(), keypoints.end(), [&](const Eigen::Vector2f& keypoint) {
    return (keypoint.cast<double>() - x_px).squaredNorm() < kMaxErrorPx * kMaxErrorPx;
  });
}

// Whether the sparse points that the view sees are where the keypoints are. False without sparse
// points: nothing can be said.
bool KeypointsFit(const std::vector<Eigen::Vector2f>& keypoints, const Scene& scene, int view_idx) {
  const View& view = scene.views[static_cast<size_t>(view_idx)];
  size_t num_checked = 0, num_found = 0;
  for (const SparsePoint& point : scene.points) {
    if (num_checked >= kMaxChecked) break;
    if (!std::binary_search(point.view_idxs.begin(), point.view_idxs.end(), view_idx)) continue;
    const Eigen::Vector3d x_in_cam = view.cam_from_world * point.x_in_world;
    if (!(x_in_cam.z() > 0)) continue;
    ++num_checked;
    if (HasNearby(keypoints, view.camera.Project(x_in_cam))) ++num_found;
  }
  return num_checked > 0 &&
         static_cast<double>(num_found) >= kMinShareFound * static_cast<double>(num_checked);
}

}  // namespace

std::vector<std::vector<Eigen::Vector2f>> ReadSceneKeypoints(const std::filesystem::path& database,
                                                             const Scene& scene) {
  const ColmapDatabase reader(database);
  std::unordered_map<std::string, ImageId> ids;
  for (const ColmapDatabase::Image& image : reader.ReadImages()) ids[image.name] = image.image_id;
  std::vector<std::vector<Eigen::Vector2f>> keypoints(scene.views.size());
  for (int v = 0; v < scene.num_views(); ++v) {
    const auto id = ids.find(scene.views[static_cast<size_t>(v)].name);
    if (id == ids.end()) continue;
    std::vector<Eigen::Vector2f> positions;
    for (const auto& keypoint : reader.ReadKeypoints(id->second)) positions.push_back(keypoint.x);
    if (KeypointsFit(positions, scene, v)) keypoints[static_cast<size_t>(v)] = std::move(positions);
  }
  return keypoints;
}

std::filesystem::path FindDatabase(const DenseWorkspace& workspace) {
  const std::filesystem::path folder =
      std::filesystem::absolute(workspace.folder).lexically_normal();
  const std::filesystem::path own = folder.has_filename() ? folder : folder.parent_path();
  for (const auto& place : {own, own.parent_path().parent_path()}) {
    const bool may_hold = place == own || own.parent_path().filename() == "dense";
    if (may_hold && std::filesystem::is_regular_file(place / "database.db")) {
      return place / "database.db";
    }
  }
  return {};
}

}  // namespace lsmvs
