// Embree 3 or 4 with one face. Only the files that are compiled with CUTICLE_EMBREE, the major version that
// CMake found, include it.
#pragma once

#ifndef CUTICLE_EMBREE
#error "CMakeLists.txt sets CUTICLE_EMBREE for the files that use Embree"
#elif CUTICLE_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace cuticle {

// A query's record, which Embree hands to callbacks as args->context. A struct that has it as its first
// member may carry data of its own. Embree 3 keeps flags in it, Embree 4 has moved them to the arguments of a
// call; both are at their defaults here.
//
// EmbreeIntersect finds the nearest hit; without one rayHit->hit.geomID stays as it is. EmbreeOccluded sets
// ray->tfar to -infinity if there is any hit.
#if CUTICLE_EMBREE >= 4
using EmbreeContext = RTCRayQueryContext;

inline void InitEmbreeContext(EmbreeContext *context) { rtcInitRayQueryContext(context); }
inline void EmbreeIntersect(RTCScene scene, EmbreeContext *context, RTCRayHit *rayHit) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = context;
    rtcIntersect1(scene, rayHit, &arguments);
}
inline void EmbreeOccluded(RTCScene scene, EmbreeContext *context, RTCRay *ray) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = context;
    rtcOccluded1(scene, ray, &arguments);
}
#else
using EmbreeContext = RTCIntersectContext;

inline void InitEmbreeContext(EmbreeContext *context) { rtcInitIntersectContext(context); }
inline void EmbreeIntersect(RTCScene scene, EmbreeContext *context, RTCRayHit *rayHit) {
    rtcIntersect1(scene, context, rayHit);
}
inline void EmbreeOccluded(RTCScene scene, EmbreeContext *context, RTCRay *ray) {
    rtcOccluded1(scene, context, ray);
}
#endif

} // namespace cuticle
