// SPDX-License-Identifier: Apache-2.0
// Embree 3 and 4 behind one set of calls; private to scene_trace.c. The versions differ in the
// folder of their headers and in how options are passed to a query: version 3 needs a context in
// every call, version 4 takes optional arguments. The types, geometry calls and callbacks that
// satin uses are the same in both.
#ifndef SCENE_EMBREE_H
#define SCENE_EMBREE_H

#include <stdbool.h>
#include <stddef.h>

#if SATIN_EMBREE == 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext embree_context;
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext embree_context;
#endif

// Data for the callbacks of scene_embree_occluded, behind the context in their arguments. In a
// callback, tfar of the ray is the distance of the hit that is tested.
struct embree_occlusion {
    embree_context context;
    float end;  // tfar of the ray
};

// Finds the nearest hit; hit.geomID stays invalid without one.
static inline void scene_embree_intersect(RTCScene scene, struct RTCRayHit *ray_hit) {
#if SATIN_EMBREE == 4
    rtcIntersect1(scene, ray_hit, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, ray_hit);
#endif
}

// Whether anything is hit. The ray is overwritten.
static inline bool scene_embree_occluded(RTCScene scene, struct RTCRay *ray) {
    struct embree_occlusion query = {.end = ray->tfar};
#if SATIN_EMBREE == 4
    struct RTCOccludedArguments arguments;
    rtcInitRayQueryContext(&query.context);
    rtcInitOccludedArguments(&arguments);
    arguments.context = &query.context;
    rtcOccluded1(scene, ray, &arguments);
#else
    rtcInitIntersectContext(&query.context);
    rtcOccluded1(scene, &query.context, ray);
#endif
    return ray->tfar < 0.0f;  // a hit sets it to -infinity
}

#endif
