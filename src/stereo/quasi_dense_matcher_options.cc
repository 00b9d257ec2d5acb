#include "lsmvs/stereo/quasi_dense_matcher.h"

namespace lsmvs {

void QuasiDenseOptions::Describe(OptionSet* options) {
  const auto name = [](const char* field) { return std::string("QuasiDenseMatching.") + field; };
  options->Add(name("spacing_px"), &spacing_px,
               "Distance of interest points [px] at each scale; time falls with its square",
               {1.0, 100.0});
  options->Add(name("window_radius"), &window_radius,
               "Radius of the matching window [px]; larger is more stable and blurs detail",
               {1, 7});
  options->Add(name("finest_level"), &finest_level,
               "finest scale: 0 full size, 1 half size; each level takes a quarter of the time",
               {0, 10});
  options->Add(name("num_scales"), &num_scales,
               "scales, each half as large as the one before; unset: down to 256 pixels", {1, 12});
  options->Add(name("noise_sigma"), &noise_sigma,
               "sensor noise in grey levels of 0-255; flatter windows have no points",
               {0.01, 50.0});
  options->Add(name("max_num_neighbors"), &max_num_neighbors,
               "Number of neighbours that coarse scales match with", {1, 16});
  options->Add(name("max_num_fine_neighbors"), &max_num_fine_neighbors,
               "Number of neighbours that a point is matched with on the finest scale", {1, 16});
  options->Add(name("min_ncc"), &min_ncc, "Minimum ZNCC of a match", {-1.0, 1.0});
  options->Add(
      name("max_mutual_error_px"), &max_mutual_error_px,
      "Maximum distance [px] between a point and the point that its match is matched back to",
      {0.0, 100.0});
  options->Add(name("min_num_views"), &min_num_views,
               "Minimum number of views that matched each other; raising it gives a cleaner and "
               "sparser cloud",
               {2, 1000});
  options->Add(name("max_reproj_error_px"), &max_reproj_error_px,
               "Maximum reprojection error [px] of an observation after optimisation; others leave "
               "the track",
               {0.0, 100.0});
  options->Add(name("loss_scale_px"), &loss_scale_px, "Scale of the robust loss [px]",
               {0.001, 100.0});
  options->Add(name("min_triangulation_angle_deg"), &min_triangulation_angle_deg,
               "Minimum triangulation angle [deg] of a point", {0.0, 90.0});
  options->Add(name("depth_min"), &depth_min,
               "nearest depth, world units; unset: from the sparse points", {1e-12, 1e12});
  options->Add(name("depth_max"), &depth_max,
               "farthest depth, world units; unset: from the sparse points", {1e-12, 1e12});
}

}  // namespace lsmvs
