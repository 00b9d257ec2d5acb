#include <algorithm>

#include "lsmvs/geometry/inverse_depth_transfer.h"
#include "lsmvs/stereo/quasi_dense/pairs.h"

namespace lsmvs::quasi_dense {

namespace {

constexpr size_t kMaxNeighbors = 32;  // bits of InterestPoint::slots

void AddOnce(int view_idx, std::vector<int>* views) {
  if (std::find(views->begin(), views->end(), view_idx) == views->end()) {
    views->push_back(view_idx);
  }
}

}  // namespace

InverseDepthTransferf MakePairTransfer(const Rigid3& from_pose, const PinholeCamera& from_camera,
                                       const Rigid3& to_pose, const PinholeCamera& to_camera) {
  const InverseDepthTransfer geometry =
      MakeInverseDepthTransfer(to_camera, from_camera, to_pose * from_pose.Inverse());
  return {geometry.homography.cast<float>(), geometry.epipole.cast<float>()};
}

bool WarpPlane(const InverseDepthTransferf& geometry, const Eigen::Vector2f& position,
               const Plane& plane, PlaneWarp* result) {
  const Eigen::Vector3f center = geometry(position, plane.q);
  if (!(center.z() > 1e-6f)) return false;
  const float scale = 1.0f / center.z();
  const Eigen::Vector2f image = center.head<2>() * scale;
  const Eigen::Vector3f along_x = geometry.homography.col(0) + geometry.epipole * plane.qx;
  const Eigen::Vector3f along_y = geometry.homography.col(1) + geometry.epipole * plane.qy;
  const Eigen::Vector2f by_x = (along_x.head<2>() - image * along_x.z()) * scale;
  const Eigen::Vector2f by_y = (along_y.head<2>() - image * along_y.z()) * scale;
  result->warp = {image.x(), image.y(), by_x.x(), by_y.x(), by_x.y(), by_y.y()};
  result->velocity = (geometry.epipole.head<2>() - image * geometry.epipole.z()) * scale;
  return true;
}

std::vector<std::vector<int>> SymmetricNeighbors(
    const std::vector<std::vector<Neighbor>>& neighbors, int max_num_neighbors) {
  const int num_views = static_cast<int>(neighbors.size());
  std::vector<std::vector<int>> result(neighbors.size());
  for (int i = 0; i < num_views; ++i) {
    for (const Neighbor& neighbor : neighbors[i]) {
      if (static_cast<int>(result[i].size()) >= max_num_neighbors) break;
      const int j = neighbor.view_idx;
      if (j >= 0 && j < num_views && j != i) AddOnce(j, &result[i]);
    }
  }
  const std::vector<std::vector<int>> chosen = result;
  for (int i = 0; i < num_views; ++i) {
    for (const int j : chosen[i]) {
      if (result[j].size() < kMaxNeighbors) AddOnce(i, &result[j]);
    }
  }
  return result;
}

std::vector<Pairing> MakePairings(const Scene& scene, const ImageStore& images, int level,
                                  int view_idx, const std::vector<int>& neighbors) {
  const Rigid3& pose = scene.views[view_idx].cam_from_world;
  const PinholeCamera camera = images.Camera(view_idx, level);
  std::vector<Pairing> pairings;
  for (const int other : neighbors) {
    const Rigid3& other_pose = scene.views[other].cam_from_world;
    const PinholeCamera other_camera = images.Camera(other, level);
    pairings.push_back({other, MakePairTransfer(pose, camera, other_pose, other_camera),
                        MakePairTransfer(other_pose, other_camera, pose, camera)});
  }
  return pairings;
}

}  // namespace lsmvs::quasi_dense
