#pragma once

// Embree of both major versions: 3 (Debian 12) and 4 (Debian 13) differ in the header's name and in
// what a query of one ray takes. The build says which one it found.
#if LSMVS_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace lsmvs {

inline void IntersectRay(RTCScene scene, RTCRayHit* query) {
#if LSMVS_EMBREE_MAJOR >= 4
  rtcIntersect1(scene, query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, query);
#endif
}

// A ray that is blocked gets a negative tfar.
inline void OccludeRay(RTCScene scene, RTCRay* ray) {
#if LSMVS_EMBREE_MAJOR >= 4
  rtcOccluded1(scene, ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, ray);
#endif
}

}  // namespace lsmvs
