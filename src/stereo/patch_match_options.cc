#include "lsmvs/stereo/patch_match.h"

namespace lsmvs {

void PatchMatchOptions::Describe(OptionSet* options) {
  const auto name = [](const char* field) { return std::string("PatchMatchStereo.") + field; };
  options->Add(
      name("window_radius"), &window_radius,
      "half size of the matching window, pixels, doubled where there is little texture; larger "
      "is smoother and blurs detail",
      {1, 20});
  options->Add(name("window_step"), &window_step,
               "pixels between samples of a window; larger is faster and noisier", {1, 10});
  options->Add(name("num_iterations"), &num_iterations, "Number of sweeps over the coarsest level",
               {1, 100});
  options->Add(name("max_num_neighbors"), &max_num_neighbors,
               "Number of neighbours that coarse levels match with", {1, 16});
  options->Add(name("max_num_fine_neighbors"), &max_num_fine_neighbors,
               "Number of neighbours kept per tile at full resolution; time grows with it",
               {1, 16});
  options->Add(
      name("sigma_spatial"), &sigma_spatial,
      "Sigma of the window's weights over the distance from its centre [px]; unset: the radius",
      {0.1, 100.0});
  options->Add(
      name("sigma_color"), &sigma_color,
      "Sigma of the window's weights over the grey difference from its centre; 1 is the full range",
      {0.001, 10.0});
  options->Add(name("noise_sigma"), &noise_sigma,
               "sensor noise in grey levels of 0-255; flatter windows keep close to what coarser "
               "levels found",
               {0.01, 50.0});
  options->Add(name("geom_consistency"), &geom_consistency, "run the geometric pass");
  options->Add(name("geom_consistency_regularizer"), &geom_consistency_regularizer,
               "Weight of the forward-backward error per pixel, against 1 - ZNCC", {0.0, 10.0});
  options->Add(name("geom_consistency_max_cost"), &geom_consistency_max_cost,
               "Forward-backward error [px] beyond which the cost grows no further", {0.0, 100.0});
  options->Add(name("filter"), &filter, "drop pixels that fail the filter_* thresholds");
  options->Add(name("filter_min_ncc"), &filter_min_ncc,
               "Minimum ZNCC, mean over the best matching views", {-1.0, 1.0});
  options->Add(
      name("filter_min_triangulation_angle"), &filter_min_triangulation_angle,
      "Minimum angle [deg] between the rays of the reference and of a consistent neighbour",
      {0.0, 180.0});
  options->Add(name("filter_min_num_consistent"), &filter_min_num_consistent,
               "Minimum number of neighbours that agree with a pixel's depth", {0, 16});
  options->Add(name("filter_geom_consistency_max_cost"), &filter_geom_consistency_max_cost,
               "Maximum forward-backward error [px] of a neighbour that agrees", {0.0, 100.0});
  options->Add(name("depth_min"), &depth_min,
               "nearest depth, world units; unset: from the sparse points", {1e-12, 1e12});
  options->Add(name("depth_max"), &depth_max,
               "farthest depth, world units; unset: from the sparse points", {1e-12, 1e12});
}

}  // namespace lsmvs
