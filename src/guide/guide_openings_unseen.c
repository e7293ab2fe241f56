// SPDX-License-Identifier: Apache-2.0
// Openings that no point sees, as a hole in a wall behind a cupboard. They are found from the other
// side: paths of the lights that are aimed at the box show through which bins light comes into it.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "guide/guide_visibility.h"

enum { UNSEEN_CHUNK = 64, NO_BIN = UINT16_MAX };

// How far a path comes into the box, over the largest extent of it: less far is the outside of a
// wall that the box touches.
#define WITHIN_LEAST 0.005f
// The least weight of a bin that light comes in by, or that is beside one. With 1 for those, blocks
// of the first pass behind a screen were off by .32 to .65 of their light instead of .31 to .40.
#define UNSEEN_LEAST 0.3f

struct unseen_paths {
    const struct satin_scene *scene;
    uint64_t seed;
    const struct light_box *box;
    struct light_aim aim;   // at the box
    const uint32_t *light;  // those infinitely far
    size_t each;            // paths of each
    uint16_t *bin;          // by path: through which it comes in
};

static uint16_t bin_of_path(const struct unseen_paths *paths, size_t i) {
    struct rng rng = rng_make(paths->seed, RNG_OPENING, i);
    struct light_ray start;
    struct interaction s;
    struct light_chain chain;
    vec3 n;
    float u[4], density;
    const uint32_t light = paths->light[i / paths->each];
    sample_sobol4((uint32_t)(i % paths->each), (uint32_t)rng_mix(paths->seed + light), u);
    if (!light_emit(paths->scene, light, &paths->aim, u, &start)) return NO_BIN;
    if (!guide_seen_follow(paths->scene, &start.ray, &rng, &s, &n, &chain)) return NO_BIN;
    const struct light_box *box = paths->box;
    const vec3 back = v3_neg(start.ray.d);
    const float least = WITHIN_LEAST * v3_max_abs(v3_sub(box->hi, box->lo));
    if (!v3_within(s.p, box->lo, box->hi) || !(guide_box_exit(box, s.p, back) > least))
        return NO_BIN;
    return (uint16_t)light_box_bin(box, s.p, back, &density);
}

static void trace_unseen(void *ctx, size_t begin, size_t end, int worker) {
    const struct unseen_paths *paths = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) paths->bin[i] = bin_of_path(paths, i);
}

// The weight of a bin is the root of the number of paths that come in by it, which leaves the least
// variance. Those beside them count too: light that is scattered in the hole comes through them.
static void set_weights(const struct unseen_paths *paths, size_t count,
                        float weight[LIGHT_HISTOGRAM_BINS]) {
    uint32_t found[LIGHT_HISTOGRAM_BINS] = {0}, most = 1;
    for (size_t i = 0; i < count; i++)
        if (paths->bin[i] != NO_BIN) found[paths->bin[i]]++;
    for (size_t bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
        if (found[bin] > most) most = found[bin];
    for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
        int around[9];
        bool open = false;
        for (int i = light_box_around(bin, around); i-- > 0;) open = open || found[around[i]] > 0;
        const float own = sqrtf((float)found[bin] / (float)most);
        weight[bin] = open ? fmaxf(own, UNSEEN_LEAST) : 0.0f;
    }
}

satin_status guide_openings_unseen(const struct satin_scene *scene, uint64_t seed,
                                   const struct light_box *box, size_t paths, struct parallel *pool,
                                   float weight[LIGHT_HISTOGRAM_BINS]) {
    uint32_t *light = array_new(scene->light_count, sizeof *light);
    size_t lights = 0;
    for (uint32_t i = 0; light && i < scene->light_count; i++)
        if (light_is_far(&scene->light[i])) light[lights++] = i;
    struct unseen_paths unseen = {
        .scene = scene,
        .seed = seed,
        .box = box,
        .aim = {.covers = 1, .count = 1, .box = {{box->lo, box->hi}}},
        .light = light,
        .each = paths / (lights > 0 ? lights : 1) + 1,
    };
    const size_t count = lights * unseen.each;
    unseen.bin = array_new(count, sizeof *unseen.bin);
    satin_status status = light && unseen.bin ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK && !parallel_for(pool, count, UNSEEN_CHUNK, trace_unseen, &unseen))
        status = SATIN_CANCELLED;
    if (status == SATIN_OK) set_weights(&unseen, count, weight);
    free(unseen.bin);
    free(light);
    return status;
}
