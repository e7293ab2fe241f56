// SPDX-License-Identifier: Apache-2.0
// For tests of filling a cache: a small scene, an empty cache over it, and sites on a square of one
// of its surfaces.
#ifndef CACHE_CASE_H
#define CACHE_CASE_H

#include <stdlib.h>

#include "base/parallel.h"
#include "cache/cache_records.h"
#include "test_scene.h"

enum { CACHE_CASE_SIDE = 40, CACHE_CASE_SITES = CACHE_CASE_SIDE * CACHE_CASE_SIDE };

struct cache_case {
    struct test_scene scene;
    satin_options options;
    struct gather g;
    struct parallel *pool;
    struct cache *cache;
    struct cache_site site[CACHE_CASE_SITES];
};

// No scene yet, and the default options, but without photons.
static inline void cache_case_begin(struct cache_case *c) {
    test_scene_init(&c->scene);
    c->options = satin_options_default;
    c->options.first_pass = SATIN_FIRST_NONE;
    c->options.max_depth = -1;
}

// The scene and the options are set: makes the cache, of harmonics of that order, and the sites,
// scattered over the square about `centre`, given by its half sides.
static inline void cache_case_finish(struct cache_case *c, int order, int threads, vec3 centre,
                                     vec3 half_u, vec3 half_v, struct cache_site site) {
    test_scene_finish(&c->scene);
    c->g = gather_make(&c->scene.scene, &c->options, NULL);
    c->pool = parallel_new(threads);
    c->cache = cache_new(&c->g, order, c->pool);
    assert_non_null(c->cache);
    site.ng = v3_unit(v3_cross(half_u, half_v));
    site.frame = frame_from_normal(site.ng);
    for (int i = 0; i < CACHE_CASE_SITES; i++) {
        int j = i * 1103 % CACHE_CASE_SITES;
        float u = 2.0f * ((float)(j % CACHE_CASE_SIDE) + 0.5f) / CACHE_CASE_SIDE - 1.0f;
        float v = 2.0f * ((float)(j / CACHE_CASE_SIDE) + 0.5f) / CACHE_CASE_SIDE - 1.0f;
        site.p = v3_mad(v3_mad(centre, u, half_u), v, half_v);
        site.stream = (uint64_t)j;
        c->site[i] = site;
    }
}

static inline void cache_case_free(struct cache_case *c) {
    cache_free(c->cache);
    parallel_free(c->pool);
    test_scene_free(&c->scene);
}

#endif
