// SPDX-License-Identifier: Apache-2.0
// Private to gather/: the memory of a worker for one chunk of hits.
#ifndef GATHER_SCRATCH_H
#define GATHER_SCRATCH_H

#include "gather/gather.h"

// Hits that are looked up together: a call of the library costs as much as ten.
enum { GATHER_CHUNK = 512 };

// The end of a gather ray, for the lookup.
struct gather_hit {
    struct shading_point point;
    rgb T;  // transmittance of the ideal specular surfaces before it
    struct gather_ray *ray;
    struct sampler sampler;
};

// A chunk of hits, and the first-pass estimate at each: the irradiance E [W m^-2], and the radius
// of its lookup.
struct gather_hits {
    struct gather_hit hit[GATHER_CHUNK];
    vec3 p[GATHER_CHUNK], n[GATHER_CHUNK];  // points and normals of the lookups
    rgb E[GATHER_CHUNK];
    float radius[GATHER_CHUNK];
    int entry[GATHER_CHUNK];
    bool near[GATHER_CHUNK];     // gather_is_near
    float bright[GATHER_CHUNK];  // approximate luminance of what the hit contributes
};

// Memory that a worker uses repeatedly. A call reads from it only what the same call has written.
struct gather_scratch {
    struct parallel *pool;  // checked for cancellation between chunks; may be NULL
    int worker;
    struct gather_hits hits;
};

#endif
