// SPDX-License-Identifier: Apache-2.0
// Embree 3 and 4 behind one set of calls. The two differ in the folder of their headers and in how
// a query passes its options: version 3 wants a context that is always there, version 4 takes
// optional arguments. Types, geometry calls and callbacks that satin uses are the same in both.
// Private to scene_trace.c.
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

// What the callbacks of embree_occluded find behind the context in their arguments. To them a ray
// ends at the hit that they are asked about.
struct embree_occlusion {
    embree_context context;
    float end;  // tfar of the ray
};

// Finds the nearest hit; hit.geomID stays invalid without one.
static inline void embree_intersect(RTCScene scene, struct RTCRayHit *ray_hit) {
#if SATIN_EMBREE == 4
    rtcIntersect1(scene, ray_hit, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, ray_hit);
#endif
}

// Whether anything is hit; the ray is spent.
static inline bool embree_occluded(RTCScene scene, struct RTCRay *ray) {
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
    return ray->tfar < 0.0f;  // set to -infinity by a hit
}

#endif
