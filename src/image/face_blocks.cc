#include "lsmvs/image/face_blocks.h"

#include <array>

namespace lsmvs {

FaceBlocks::FaceBlocks(std::span<const Eigen::Vector3d> vertices,
                       std::span<const Eigen::Vector3i> faces, const RunContext& context) {
  boxes_.resize((faces.size() + kFacesPerBlock - 1) / kFacesPerBlock);
  ParallelBlocks(context, faces.size(), kFacesPerBlock, [&](size_t begin, size_t end) {
    Eigen::AlignedBox3d box;
    for (size_t f = begin; f < end; ++f) {
      for (const int v : faces[f]) box.extend(vertices[static_cast<size_t>(v)]);
    }
    boxes_[begin / kFacesPerBlock] = box;
  });
}

std::vector<uint32_t> FaceBlocks::SeenBy(const PinholeCamera& camera,
                                         const Rigid3& cam_from_world) const {
  std::vector<uint32_t> seen;
  for (size_t b = 0; b < boxes_.size(); ++b) {
    if (MayShow(camera, cam_from_world, boxes_[b])) seen.push_back(static_cast<uint32_t>(b));
  }
  return seen;
}

bool MayShow(const PinholeCamera& camera, const Rigid3& cam_from_world,
             const Eigen::AlignedBox3d& box) {
  // What lies before the camera and within the image is on the positive side of five planes through
  // its centre.
  const std::array<Eigen::Vector3d, 5> planes = {{{0, 0, 1},
                                                  {camera.fx, 0, camera.cx},
                                                  {-camera.fx, 0, camera.width - camera.cx},
                                                  {0, camera.fy, camera.cy},
                                                  {0, -camera.fy, camera.height - camera.cy}}};
  const Eigen::Vector3d half = 0.5 * box.sizes(), x = cam_from_world * box.center();
  for (const Eigen::Vector3d& plane : planes) {
    // The corner that is furthest on the plane's positive side.
    const Eigen::Vector3d in_world = cam_from_world.rotation.transpose() * plane;
    const double most = plane.dot(x) + in_world.cwiseAbs().dot(half);
    constexpr double kRounding = 1e-9;
    const double scale = plane.cwiseAbs().dot(x.cwiseAbs()) + in_world.cwiseAbs().dot(half);
    if (most < -kRounding * scale) return false;
  }
  return true;
}

}  // namespace lsmvs
