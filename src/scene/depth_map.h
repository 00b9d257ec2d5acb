#pragma once

#include <Eigen/Core>
#include <memory>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// Of the two passes of stereo: from the photos alone, and with the neighbours' maps.
enum class DepthMapKind { kPhotometric, kGeometric };

// Depth and normal of one view, at the centres of the pixels of some level of its image (the size
// says which: scale the camera with PinholeCamera::Resized). On disk COLMAP's maps mean pixel
// corners instead: the adapter converts.
struct DepthMap {
  Raster<float> depth;  // z in the camera frame, in world units; 0 where unknown
  Raster<Eigen::Vector3f>
      normal;  // camera frame, unit length, z < 0 (towards the camera); zero where unknown
};

// Where fusion and the geometric pass get the maps of other views from: a cache over files, or
// memory in tests.
class DepthMapSource {
 public:
  virtual ~DepthMapSource() = default;
  // Null if the view has no map. Thread-safe.
  virtual std::shared_ptr<const DepthMap> Get(int view_idx) const = 0;
};

}  // namespace lsmvs
