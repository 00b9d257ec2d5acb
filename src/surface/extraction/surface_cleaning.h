#pragma once

#include "lsmvs/surface/cleaning_options.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/surface_extraction.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Trims facets that span what nobody measured, drops components that float, closes small holes,
// sinks lone spikes, smooths; sets vertex colours. `visibility_sigma` is that of
// PointMergingOptions.
//
// Trimming weighs for each facet how far it goes beyond what is believed of a surface (its stress,
// a ratio whose logarithm stands for a log-likelihood ratio, per square pixel of the facet) against
// the border that dropping it makes (TrimSurface).
SurfaceCleaningCounters CleanSurface(const Scene& scene, const MergedCloud& cloud,
                                     const SurfaceCleaningOptions& options, double visibility_sigma,
                                     const RunContext& context, ExtractedSurface* surface);

}  // namespace lsmvs
