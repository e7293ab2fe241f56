// SPDX-License-Identifier: Apache-2.0
// Private to gather/: a worker's memory for one hemisphere and one chunk of hits.
#ifndef GATHER_SCRATCH_H
#define GATHER_SCRATCH_H

#include "gather/gather.h"

enum { GATHER_CHUNK = 512 };  // hits looked up together: a call of the library costs as much as ten

// Where a gather ray ended, ready for the lookup.
struct gather_hit {
    struct gather_point point;
    rgb T;  // what ideal specular surfaces before it leave of the light
    struct gather_ray *ray;
    struct sampler sampler;
};

// The bright places around a site, for the next bounce of rays that hit near to it (gather_near.c).
struct gather_near {
    struct guide_cone cone[GUIDE_CONES];
    float seen[GUIDE_CONES];  // fraction of the near hits that see it, never 0
    int found;                // cones around the site; negative: not yet known
    int count;                // of them, first in `cone`, those that matter to the hits
};

// The bright places that a site sees, and the rays that it sends there (gather_guide.c).
struct gather_guide {
    struct guide_rays to;
    struct frame frame;         // of the site
    size_t first[GUIDE_CONES];  // ray of a cone
    size_t made;                // of the rays: none goes below the horizon
    vec3 p;                     // of the site,
    float expected;             // and roughly its irradiance
    struct gather_near near;
};

struct gather_scratch {
    size_t capacity;          // half as many again as asked for: guided rays
    struct gather_ray *rays;  // capacity
    float *x, *y, *z;         // capacity: local directions
    float *r, *g, *b;         // capacity: weighted radiance
    float *wall;              // 6 * capacity: of gradients
    struct parallel *pool;    // asked between chunks whether to go on; NULL: it is not
    int worker;
    struct gather_guide guide;
    struct gather_hit hit[GATHER_CHUNK];
    vec3 p[GATHER_CHUNK], n[GATHER_CHUNK];
    rgb E[GATHER_CHUNK];
    float radius[GATHER_CHUNK];
};

#endif
