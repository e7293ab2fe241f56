// SPDX-License-Identifier: Apache-2.0
// Private to gather/: the memory of a worker for the hits of gather rays.
#ifndef GATHER_SCRATCH_H
#define GATHER_SCRATCH_H

#include "gather/gather.h"

// The largest number of hits that are looked up together: a call of the library costs as much as
// ten.
enum { GATHER_HITS_MOST = 512 };

// The end of a gather ray, for the lookup.
struct gather_hit {
    struct shading_point point;
    rgb T;         // transmittance of the ideal specular surfaces before it
    int specular;  // number of these
    struct gather_ray *ray;
    struct sampler sampler;
};

// Hits that are looked up together, and the first-pass estimate at each: the irradiance E [W m^-2],
// and the radius of its lookup.
struct gather_hits {
    struct gather_hit hit[GATHER_HITS_MOST];
    vec3 p[GATHER_HITS_MOST], n[GATHER_HITS_MOST];  // points and normals of the lookups
    int more[GATHER_HITS_MOST];  // segments from the eye beyond those to what gather rays of the
                                 // image hit
    rgb E[GATHER_HITS_MOST];
    float radius[GATHER_HITS_MOST];
    int entry[GATHER_HITS_MOST];
    bool reliable[GATHER_HITS_MOST];  // whether the estimate is read
    float bright[GATHER_HITS_MOST];   // approximate luminance of what the hit contributes
};

// Memory that a worker uses repeatedly. A call reads from it only what the same call has written.
struct gather_scratch {
    struct parallel *pool;  // checked for cancellation between calls; may be NULL
    int worker;
    struct gather_hits hits;
};

#endif
