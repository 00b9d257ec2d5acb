#pragma once

#include "lsmvs/stereo/quasi_dense/points.h"

namespace lsmvs::quasi_dense {

// The plane through the matched points around `position`, at `position`: robust least squares of
// inverse depth (iteratively reweighted, Cauchy) over the cells within `reach`, starting at
// `guess`. `tolerance` is the error of inverse depth that a match has: points farther off the plane
// count little, so that it does not bend over an edge of depth. Returns `guess` where fewer than
// five points, or points in a line, are around.
Plane FitPlane(const PointGrid& grid, const Eigen::Vector2f& position, const Plane& guess,
               float tolerance, int reach);

// The same plane in the pixels of another scale, whose image coordinates are those of `plane` times
// `scale`, at the offset (dx, dy) in its own pixels.
Plane MovePlane(const Plane& plane, const Eigen::Vector2f& offset, const Eigen::Vector2f& scale);

}  // namespace lsmvs::quasi_dense
