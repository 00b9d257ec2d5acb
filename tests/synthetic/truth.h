#pragma once

#include <memory>
#include <vector>

#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/synthetic/shape.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Exact depth and normal (in the camera frame) at every pixel centre of the view's camera; 0 where
// the ray meets nothing.
DepthMap TrueDepthMap(const Shape& shape, const View& view, const RunContext& context);
// The same for a view whose image is resized.
DepthMap TrueDepthMap(const Shape& shape, const View& view, int width, int height,
                      const RunContext& context);

// Whether the view sees a point on the surface: it projects into the image, its normal makes less
// than `max_angle_deg` with the line of sight, and nothing is in between.
bool SeesSurfacePoint(const Shape& shape, const View& view, const Eigen::Vector3d& x_in_world,
                      const Eigen::Vector3d& normal, double max_angle_deg = 80.0);

// Depth maps that are already in memory.
class MemoryDepthMaps : public DepthMapSource {
 public:
  explicit MemoryDepthMaps(std::vector<DepthMap> maps);
  std::shared_ptr<const DepthMap> Get(int view_idx) const override;

 private:
  std::vector<std::shared_ptr<const DepthMap>> maps_;
};

}  // namespace lsmvs
