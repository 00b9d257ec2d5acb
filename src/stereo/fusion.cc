#include "lsmvs/stereo/fusion.h"

namespace lsmvs {

void FusionOptions::Describe(OptionSet* options) {
  const auto name = [](const char* field) { return std::string("StereoFusion.") + field; };
  options->Add(name("min_num_pixels"), &min_num_pixels,
               "views that must agree on a point; more is cleaner and sparser", {1, 1000});
  options->Add(name("max_num_pixels"), &max_num_pixels, "views averaged into one point at most",
               {1, 1000000});
  options->Add(name("max_reproj_error"), &max_reproj_error,
               "pixels between a pixel and the point it joins", {0.0, 100.0});
  options->Add(name("max_depth_error"), &max_depth_error,
               "relative difference of depth within which a pixel joins a point", {0.0, 1.0});
  options->Add(name("max_normal_error"), &max_normal_error,
               "degrees between normals within which a pixel joins a point", {0.0, 180.0});
  options->Add(name("check_num_images"), &check_num_images,
               "neighbouring views checked a reference view", {1, 1000});
}

VisibilityCloud FuseDepthMaps(const Scene&, const ImageStore&,
                              const std::vector<std::vector<Neighbor>>&, const DepthMapSource&,
                              const FusionOptions&, const RunContext&) {
  return {};
}

CostEstimate EstimateFusionCost(const Scene&, const ImageStore&, const FusionOptions&) {
  return {};
}

}  // namespace lsmvs
