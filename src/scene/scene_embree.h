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
#else
#include <embree3/rtcore.h>
#endif

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
#if SATIN_EMBREE == 4
    rtcOccluded1(scene, ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, ray);
#endif
    return ray->tfar < 0.0f;  // set to -infinity by a hit
}

#endif
