#pragma once

#include <cstddef>

#include "lsmvs/scene/scene.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/visibility_weights.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct FreeSpaceFilterOptions {
  // Coarser resolutions, each of a quarter of the one below: about a 16th of the vertices.
  int num_levels = 0;
  PointMergingOptions merging;      // of the finest level
  VisibilityWeightOptions weights;  // of all levels
  size_t cells_at_once = 0;         // as part_size of MaximizeFlow
};

// The multi-level filter: on the coarsest level first, drops vertices that the surface of that
// level leaves in free space, so that the finer levels never see them (H.-H. Vu, PhD thesis, 2011,
// 6.2.4). Returns how many were dropped.
//
// On a level, the vertices are merged once more, with `4^level` times the reach, and a surface is
// cut through these. A vertex goes if it lies in an empty tetrahedron of the level and no vertex of
// the level's surface is within two coarse reaches: what is nearer may be detail that the level
// does not resolve. And what is thin stays: on a level, what vertices say of the space behind them
// weighs as much more as its spacing is wider than the finest, so that a strip as wide as the
// finest spacing, past which most of the rays go that the level's tetrahedra hold, is no outlier
// yet. A level without a surface drops nothing.
//
// Same result for any number of threads and any size of the memory. Time: about that of the surface
// of a 16th of the vertices, and one merging of them all; memory: less than the finest level takes.
size_t FilterFreeSpace(const Scene& scene, const FreeSpaceFilterOptions& options,
                       const RunContext& context, MergedCloud* cloud);

}  // namespace lsmvs
