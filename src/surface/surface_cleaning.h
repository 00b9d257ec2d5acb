#pragma once

#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/surface_extraction.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct SurfaceCleaningOptions {
  double max_side_length_factor = 64, max_side_length_percentile = 50;
  double max_depth_extent_factor = 16;
  double normal_check_factor = 16, max_normal_angle_deg = 70;
  double min_component_fraction = 0.002;
  int min_component_faces = 50;
  int max_hole_edges = 40;
  int smoothing_iterations = 2;
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
