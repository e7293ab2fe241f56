// SPDX-License-Identifier: Apache-2.0
// How large what is seen is: the median length of gather rays, by a few of them. A photon lookup
// that blurs over such a length is worth nothing (struct gather, trust).
#include <stdlib.h>

#include "shade/shade_eye.h"

enum { PIXELS = 1024 };

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// The length of a ray from what eye ray `i` sees; INFINITY if one of them meets nothing.
static float gather_length(const struct shade *shade, uint32_t i) {
    const struct film_spec *film = &shade->g->scene->film;
    vec2 u = sample_sobol2(i, 0), v = sample_sobol2(i, 1);
    int x = (int)(u.x * (float)film->crop_width), y = (int)(u.y * (float)film->crop_height);
    struct sampler sampler = shade_eye_sampler(shade->g, x, y, 0, RNG_REACH);
    struct shade_eye eye;
    shade_eye_trace(shade, x, y, &sampler, &eye);
    if (eye.count == 0) return INFINITY;
    const struct gather_point *p = &eye.vertex[0].point;
    vec3 d = frame_to_world(&p->frame, sample_cosine_hemisphere(v.x, v.y));
    struct ray ray = scene_spawn(shade->g->scene, p->surfel.p, p->surfel.ng, d);
    return scene_distance(shade->g->scene, &ray);
}

float shade_reach(const struct shade *shade) {
    float length[PIXELS];
    int count = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        float t = gather_length(shade, i);
        if (isfinite(t)) length[count++] = t;
    }
    if (count == 0) return INFINITY;
    qsort(length, (size_t)count, sizeof *length, compare_floats);
    return length[count / 2];
}
