#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// For each point the number of views that see it: it lies before the camera, inside the image, and
// nothing of `occluder` (null: nothing is in the way) lies on the segment to the camera, but for
// the last `tolerance` (world units) before the point.
std::vector<int> CountViews(const std::vector<Eigen::Vector3d>& points,
                            const std::vector<View>& views, const MeshTracer* occluder,
                            double tolerance, const RunContext& context);

// How much surface one pixel covers: the median over the views of the median depth of the points
// inside a view, over the view's horizontal focal length. 0 if no view holds a point.
double SurfaceSamplingDistance(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<View>& views);

}  // namespace lsmvs
