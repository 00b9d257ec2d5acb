#pragma once

#include <memory>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/stereo/quasi_dense_matcher.h"
#include "lsmvs/stereo/quasi_dense_points_internal.h"
#include "lsmvs/stereo/quasi_dense_search_internal.h"
#include "lsmvs/stereo/quasi_dense_triangulation_internal.h"

namespace lsmvs::quasi_dense {

// What all views share while tracks are made, on the finest scale.
struct TrackWorld {
  const Scene& scene;
  const QuasiDenseOptions& options;
  const std::vector<PointGrid>& grids;        // by view
  std::vector<ProjectionMatrix> projections;  // by view
  std::vector<PinholeCamera> cameras;         // by view
  // By view and cell: 1 where a track of an earlier view covers the interest point.
  std::vector<Raster<uint8_t>> covered;
};

// Makes the tracks of the matched interest points of one view that none covers yet: asks the
// neighbours, measures where each that agrees sees the point (along its epipolar line, to a
// fraction of a pixel), triangulates, optimises, checks; appends the points that pass to the cloud,
// in the order of the cells, and covers the interest points that took part. `colors` is the
// reference's image.
void MakeTracks(int view_idx, const SearchView& view, const ColorImage& colors,
                const RunContext& context, TrackWorld* world, VisibilityCloud* cloud,
                QuasiDenseCounters* counters);

}  // namespace lsmvs::quasi_dense
