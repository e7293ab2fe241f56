// SPDX-License-Identifier: Apache-2.0
// Private to gather/: the memory of a worker for one hemisphere and one chunk of hits.
#ifndef GATHER_SCRATCH_H
#define GATHER_SCRATCH_H

#include "gather/gather.h"

enum {
    GATHER_CHUNK = 512
};  // hits that are looked up together: a call of the library costs as
    // much as ten

// The end of a gather ray, for the lookup.
struct gather_hit {
    struct gather_point point;
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
};

// Memory that a worker uses repeatedly. A call reads from it only what the same call has written,
// or what belongs to a hemisphere that it was given.
struct gather_scratch {
    size_t capacity;          // half as many again as requested, for guided rays
    struct gather_ray *rays;  // capacity
    float *x, *y, *z;         // capacity: local directions
    float *r, *g, *b;         // capacity: radiance times solid angle
    float *work;              // 6 * capacity
    struct parallel *pool;    // checked for cancellation between chunks; may be NULL
    int worker;
    struct gather_hits hits;
};

// The hemisphere of a layout's stratified rays in the scratch; the caller sets the rays.
static inline struct gather_hemisphere gather_scratch_hemisphere(
    const struct gather_scratch *scratch, const struct gather_layout *layout,
    const struct frame *frame) {
    const struct gather_scratch *s = scratch;
    const size_t count = gather_layout_rays(layout);
    return (struct gather_hemisphere){.layout = layout,
                                      .frame = *frame,
                                      .stratified = count,
                                      .count = count,
                                      .ray = s->rays,
                                      .x = s->x,
                                      .y = s->y,
                                      .z = s->z,
                                      .r = s->r,
                                      .g = s->g,
                                      .b = s->b,
                                      .work = s->work};
}

#endif
