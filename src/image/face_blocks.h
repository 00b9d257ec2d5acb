#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Boxes around the vertices of faces that follow each other: what a camera sees of a large mesh,
// without a look at each face. Useful where faces that are near each other have numbers that are.
class FaceBlocks {
 public:
  static constexpr size_t kFacesPerBlock = 512;

  // O(#F); 48 bytes a block. The mesh is not kept.
  FaceBlocks(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3i> faces,
             const RunContext& context);

  // The blocks, ascending, but for those whose box lies outside of the image or behind the camera.
  std::vector<uint32_t> SeenBy(const PinholeCamera& camera, const Rigid3& cam_from_world) const;

 private:
  std::vector<Eigen::AlignedBox3d> boxes_;
};

// Whether a part of a box may lie in the image, before the camera. False is certain.
bool MayShow(const PinholeCamera& camera, const Rigid3& cam_from_world,
             const Eigen::AlignedBox3d& box);

}  // namespace lsmvs
