// SPDX-License-Identifier: Apache-2.0
// For tests of filling a cache: a small scene, an empty cache over it, and sites on a square of one
// of its surfaces.
#ifndef FILL_CASE_H
#define FILL_CASE_H

#include <stdlib.h>

#include "base/parallel.h"
#include "fill/fill_record.h"
#include "test_scene.h"

enum { FILL_CASE_SIDE = 40, FILL_CASE_SITES = FILL_CASE_SIDE * FILL_CASE_SIDE };

struct fill_case {
    struct test_scene scene;
    satin_options options;
    struct gather g;
    struct parallel *pool;
    struct cache *cache;
    struct fill *fill;
    struct fill_site site[FILL_CASE_SITES];
};

// No scene yet, and the default options, but without photons.
static inline void fill_case_begin(struct fill_case *c) {
    test_scene_init(&c->scene);
    c->options = satin_options_default;
    c->options.first_pass = SATIN_FIRST_NONE;
    c->options.max_depth = -1;
}

// The scene and the options are set: makes the cache, of harmonics of that order, and the sites,
// scattered over the square about `centre`, given by its half sides.
static inline void fill_case_finish(struct fill_case *c, int order, int threads, vec3 centre,
                                    vec3 half_u, vec3 half_v, struct fill_site site) {
    test_scene_finish(&c->scene);
    c->g = gather_make(&c->scene.scene, &c->options, NULL);
    c->pool = parallel_new(threads);
    c->cache = cache_new(c->g.scene, c->g.options, order);
    assert_non_null(c->cache);
    c->fill = fill_new(c->cache, &c->g, c->pool);
    assert_non_null(c->fill);
    site.ng = v3_unit(v3_cross(half_u, half_v));
    site.frame = frame_from_normal(site.ng);
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        int j = i * 1103 % FILL_CASE_SITES;
        float u = 2.0f * ((float)(j % FILL_CASE_SIDE) + 0.5f) / FILL_CASE_SIDE - 1.0f;
        float v = 2.0f * ((float)(j / FILL_CASE_SIDE) + 0.5f) / FILL_CASE_SIDE - 1.0f;
        site.p = v3_mad(v3_mad(centre, u, half_u), v, half_v);
        site.stream = (uint64_t)j;
        c->site[i] = site;
    }
}

static inline void fill_case_free(struct fill_case *c) {
    fill_free(c->fill);
    cache_free(c->cache);
    parallel_free(c->pool);
    test_scene_free(&c->scene);
}

#endif
