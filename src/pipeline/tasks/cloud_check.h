#pragma once

#include <cstddef>
#include <string>

#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"

namespace lsmvs {

// How well points fit the views that are said to see them, each in [0, 1], over a fixed sample of
// points.
struct CloudFit {
  double inside = 1;  // of (point, view) pairs: the point lies before the view and in its image
  double facing = 1;  // of those with a normal: it is turned towards the view
};
CloudFit MeasureCloudFit(const Scene& scene, const VisibilityCloud& cloud);

// What to tell the user if hardly any of a cloud's places ended up on the surface, so that its
// views contradict each other, or if the points do not fit their views (where all photos look the
// same way, the surface may be large and wrong): figures and the likely cause. Else empty.
// `num_places`: vertices of the tetrahedralisation; `num_on_surface`: of the mesh.
std::string ContradictionWarning(const CloudFit& fit, size_t num_places, size_t num_on_surface);

}  // namespace lsmvs
