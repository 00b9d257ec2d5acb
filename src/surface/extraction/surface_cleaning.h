#pragma once

#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/surface_extraction.h"
#include "lsmvs/surface/visibility_mesher.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// As VisibilityMesherOptions, which explains them and has their defaults.
struct SurfaceCleaningOptions {
  Completeness completeness = Completeness::kClosed;
  double max_gap_share = 0;
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
  size_t num_dropped_webs = 0, num_components = 0, num_dropped_components = 0,
         num_dropped_component_faces = 0, num_closed_holes = 0;
};

// Trims facets that span what nobody measured, drops components that float, closes small holes,
// smooths; sets vertex colours.
//
// Trimming weighs for each facet how far it goes beyond what is believed of a surface (its stress,
// a ratio whose logarithm stands for a log-likelihood ratio, per square pixel of the facet) against
// the border that dropping it makes (TrimSurface).
SurfaceCleaningCounters CleanSurface(const Scene& scene, const MergedCloud& cloud,
                                     const SurfaceCleaningOptions& options,
                                     const RunContext& context, ExtractedSurface* surface);

}  // namespace lsmvs
