#pragma once

#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/surface_extraction.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// As VisibilityMesherOptions, which explains them and has their defaults.
struct SurfaceCleaningOptions {
  double max_side_length_factor = 0, max_side_length_percentile = 0;
  double max_web_factor = 0;
  double normal_check_factor = 0, max_normal_angle_deg = 0;
  double visibility_sigma = 0;
  double min_component_fraction = 0;
  int min_component_faces = 0;
  int max_hole_edges = 0;
  int smoothing_iterations = 0;
};

struct SurfaceCleaningCounters {
  size_t num_dropped_facets = 0, num_dropped_webs = 0, num_components = 0,
         num_dropped_components = 0, num_dropped_component_faces = 0, num_closed_holes = 0;
};

// Drops facets that span what nobody measured and components that float, closes small holes,
// smooths; sets vertex colours.
SurfaceCleaningCounters CleanSurface(const Scene& scene, const MergedCloud& cloud,
                                     const SurfaceCleaningOptions& options,
                                     const RunContext& context, ExtractedSurface* surface);

}  // namespace lsmvs
