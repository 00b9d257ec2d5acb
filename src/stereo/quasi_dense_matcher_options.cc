#include "lsmvs/stereo/quasi_dense_matcher.h"

namespace lsmvs {

void QuasiDenseOptions::Describe(OptionSet* options) {
  const auto name = [](const char* field) { return std::string("QuasiDenseMatching.") + field; };
  options->Add(name("spacing_px"), &spacing_px,
               "pixels between interest points at each scale; time falls with its square",
               {1.0, 100.0});
  options->Add(name("window_radius"), &window_radius,
               "half size of the matching window, pixels; larger is surer and blurs detail",
               {1, 7});
  options->Add(name("finest_level"), &finest_level,
               "finest scale: 0 full size, 1 half size; time falls fourfold a level", {0, 10});
  options->Add(name("num_scales"), &num_scales,
               "scales, each half as large as the one before; unset: down to 256 pixels", {1, 12});
  options->Add(name("noise_sigma"), &noise_sigma,
               "sensor noise in grey levels of 0-255; flatter windows have no points",
               {0.01, 50.0});
  options->Add(name("max_num_neighbors"), &max_num_neighbors,
               "neighbours that coarse scales match with", {1, 16});
  options->Add(name("max_num_fine_neighbors"), &max_num_fine_neighbors,
               "neighbours that a point is matched with on the finest scale", {1, 16});
  options->Add(name("min_ncc"), &min_ncc, "smallest ZNCC of a match; lower is more lenient",
               {-1.0, 1.0});
  options->Add(name("max_mutual_error_px"), &max_mutual_error_px,
               "pixels between a point and where its match is matched back to", {0.0, 100.0});
  options->Add(name("min_num_views"), &min_num_views,
               "views that must have matched each other; more is cleaner and sparser", {2, 1000});
  options->Add(name("max_reproj_error_px"), &max_reproj_error_px,
               "pixels; observations with a larger error after optimisation leave the track",
               {0.0, 100.0});
  options->Add(name("loss_scale_px"), &loss_scale_px,
               "pixels of error at which the robust loss begins to flatten", {0.001, 100.0});
  options->Add(name("min_triangulation_angle_deg"), &min_triangulation_angle_deg,
               "degrees under which two views of a track must see the point", {0.0, 90.0});
  options->Add(name("depth_min"), &depth_min,
               "nearest depth, world units; unset: from the sparse points", {1e-12, 1e12});
  options->Add(name("depth_max"), &depth_max,
               "farthest depth, world units; unset: from the sparse points", {1e-12, 1e12});
}

}  // namespace lsmvs
