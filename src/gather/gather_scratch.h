// SPDX-License-Identifier: Apache-2.0
// Private to gather/: a worker's memory for one hemisphere and one chunk of hits.
#ifndef GATHER_SCRATCH_H
#define GATHER_SCRATCH_H

#include "gather/gather.h"

enum { GATHER_CHUNK = 512 };  // hits looked up together: a call of the library costs as much as ten

// Where a gather ray ended, ready for the lookup.
struct gather_hit {
    struct gather_point point;
    rgb T;         // throughput of the delta chain before it
    uint32_t ray;  // index among the rays
    struct sampler sampler;
};

struct gather_scratch {
    size_t capacity;
    struct gather_ray *rays;  // capacity
    float *x, *y, *z;         // capacity: local directions
    float *r, *g, *b;         // capacity: weighted radiance
    float *wall;              // 6 * capacity: of gradients
    struct gather_hit hit[GATHER_CHUNK];
    vec3 p[GATHER_CHUNK], n[GATHER_CHUNK];
    rgb E[GATHER_CHUNK];
    float radius[GATHER_CHUNK];
};

#endif
