#pragma once

namespace lsmvs {

// Relative difference of depth above which a view does not see a surface point: another surface
// hides it. It covers how far a rendered depth map is from the surface between its pixels.
inline constexpr double kDefaultDepthTolerance = 0.01;

}  // namespace lsmvs
