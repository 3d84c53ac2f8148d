#pragma once
// Embree 3 (Debian 12) or 4 (Debian 13), which differ in the header and in how a ray is asked for.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace collided::cli {

#if RTC_VERSION_MAJOR >= 4
inline void find_hit(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray, nullptr); }
inline void find_any(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, nullptr); }
#else
inline RTCIntersectContext plain_context() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return context;
}
inline void find_hit(RTCScene scene, RTCRayHit& ray) {
  auto context = plain_context();
  rtcIntersect1(scene, &context, &ray);
}
inline void find_any(RTCScene scene, RTCRay& ray) {
  auto context = plain_context();
  rtcOccluded1(scene, &context, &ray);
}
#endif

}  // namespace collided::cli
