#pragma once

#include "lsmvs/stereo/sampling/plane_map.h"
#include "lsmvs/stereo/sampling/zncc_kernel.h"

namespace lsmvs {

// The map of a source view that the geometric term compares with.
struct SourcePlanes {
  const PlaneMap* planes = nullptr;  // null: nothing is known
  // Homogeneous map coordinates of reference coordinates (u, v) at inverse depth q are
  // forward_m (u, v, 1) + forward_e q, and back from map coordinates and the inverse depth there.
  // Both in image coordinates (pixel centres at 0.5).
  float forward_m[9] = {}, forward_e[3] = {};
  float backward_m[9] = {}, backward_e[3] = {};
};

// error_px[lane]: how far from its pixel a reference point at inverse depth planes.q lands after it
// was projected into the source, moved along that ray to the depth that the source's map has there
// (its plane, at the exact position), and projected back. Cut at `max_px`, which is also the value
// where the map says nothing.
void ForwardBackwardError(const PatchPacket& patch, const PlanePacket& planes,
                          const SourcePlanes& source, float max_px, float* error_px);

}  // namespace lsmvs
