#pragma once

#include <memory>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/stereo/quasi_dense/cross_check.h"
#include "lsmvs/stereo/quasi_dense/points.h"
#include "lsmvs/stereo/quasi_dense/search.h"
#include "lsmvs/stereo/quasi_dense/triangulation.h"
#include "lsmvs/stereo/quasi_dense_matcher.h"

namespace lsmvs::quasi_dense {

// What all views share while tracks are made, on the finest scale.
struct TrackWorld {
  const Scene& scene;
  const QuasiDenseOptions& options;
  std::vector<ProjectionMatrix> projections;  // by view
  std::vector<PinholeCamera> cameras;         // by view
  // By view and cell: whether a track of an earlier view covers the interest point. Empty before
  // the first that does, and after the view's turn.
  std::vector<std::vector<bool>> covered;
};

// Makes the tracks of the matched interest points of one view that none covers yet: asks the
// neighbours, measures where each that agrees sees the point (along its epipolar line, to a
// fraction of a pixel), triangulates, optimises, checks; returns the points that pass in the order
// of the cells, and covers the interest points of later views that took part. Views are taken in
// order. `colors` is the reference's image.
VisibilityCloud MakeTracks(int view_idx, const SearchView& view, const NeighborGrids& grids,
                           const ColorImage& colors, const RunContext& context, TrackWorld* world,
                           QuasiDenseCounters* counters);

}  // namespace lsmvs::quasi_dense
