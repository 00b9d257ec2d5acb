#include "lsmvs/stereo/patch_match.h"

namespace lsmvs {

int PhotometricLevel(const PatchMatchOptions& options) { return options.geom_consistency ? 1 : 0; }

DepthMap EstimateDepthMap(const Scene&, const ImageStore& images, int view_idx,
                          const std::vector<Neighbor>&, const DepthRange&, const DepthMapSource*,
                          const PatchMatchOptions&, const RunContext&) {
  const PinholeCamera camera = images.Camera(view_idx, 0);
  return {Raster<float>(camera.width, camera.height),
          Raster<Eigen::Vector3f>(camera.width, camera.height, Eigen::Vector3f::Zero())};
}

CostEstimate EstimatePatchMatchCost(const Scene&, const ImageStore&, const PatchMatchOptions&) {
  return {};
}

}  // namespace lsmvs
