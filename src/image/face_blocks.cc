#include "lsmvs/image/face_blocks.h"

#include <algorithm>
#include <array>
#include <limits>

namespace lsmvs {

FaceBlocks::FaceBlocks(std::span<const Eigen::Vector3d> vertices,
                       std::span<const Eigen::Vector3i> faces, const RunContext& context) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const Box none{Eigen::Vector3d::Constant(kFar), Eigen::Vector3d::Constant(-kFar)};
  boxes_.assign((faces.size() + kFacesPerBlock - 1) / kFacesPerBlock, none);
  ParallelBlocks(context, faces.size(), kFacesPerBlock, [&](size_t begin, size_t end) {
    Box box = none;
    for (size_t f = begin; f < end; ++f) {
      for (const int v : faces[f]) {
        const Eigen::Vector3d& x = vertices[static_cast<size_t>(v)];
        box.min = box.min.cwiseMin(x);
        box.max = box.max.cwiseMax(x);
      }
    }
    boxes_[begin / kFacesPerBlock] = box;
  });
}

std::vector<uint32_t> FaceBlocks::SeenBy(const PinholeCamera& camera,
                                         const Rigid3& cam_from_world) const {
  std::vector<uint32_t> seen;
  for (size_t b = 0; b < boxes_.size(); ++b) {
    if (MayShow(camera, cam_from_world, boxes_[b].min, boxes_[b].max)) {
      seen.push_back(static_cast<uint32_t>(b));
    }
  }
  return seen;
}

bool MayShow(const PinholeCamera& camera, const Rigid3& cam_from_world,
             const Eigen::Vector3d& box_min, const Eigen::Vector3d& box_max) {
  // What lies before the camera and within the image is on the positive side of five planes through
  // its centre.
  const Rigid3& pose = cam_from_world;
  const std::array<Eigen::Vector3d, 5> planes = {{{0, 0, 1},
                                                  {camera.fx, 0, camera.cx},
                                                  {-camera.fx, 0, camera.width - camera.cx},
                                                  {0, camera.fy, camera.cy},
                                                  {0, -camera.fy, camera.height - camera.cy}}};
  const Eigen::Vector3d middle = 0.5 * (box_min + box_max), half = 0.5 * (box_max - box_min);
  const Eigen::Vector3d x = pose * middle;
  const Eigen::Matrix3d rotation = pose.rotation;
  for (const Eigen::Vector3d& plane : planes) {
    // The corner that is furthest on the plane's positive side.
    const Eigen::Vector3d in_world = rotation.transpose() * plane;
    const double most = plane.dot(x) + in_world.cwiseAbs().dot(half);
    constexpr double kRounding = 1e-9;
    const double scale = plane.cwiseAbs().dot(x.cwiseAbs()) + in_world.cwiseAbs().dot(half);
    if (most < -kRounding * scale) return false;
  }
  return true;
}

}  // namespace lsmvs
