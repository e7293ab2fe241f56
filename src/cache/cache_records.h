// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the records and what is shared by filling and reading.
#ifndef CACHE_RECORDS_H
#define CACHE_RECORDS_H

#include "cache/cache.h"
#include "cache/cache_tree.h"

// A radiance record's value, laid out for products with a BRDF: for each coefficient k, CACHE_LANES
// floats: Lambda r g b 0, d/dx r g b 0, d/dy r g b 0.
enum { CACHE_LANES = 12 };

struct cache_radiance_record {
    struct frame frame;
    float *value;  // order^2 * CACHE_LANES
};

struct cache {
    const struct gather *g;
    struct parallel *pool;
    int order;  // of radiance records; 0: none

    struct cache_tree irradiance_tree;
    struct gather_irradiance *irradiance;
    size_t irradiance_capacity;

    struct cache_tree radiance_tree;
    struct cache_radiance_record *radiance;
    size_t radiance_capacity;
    struct arena radiance_arena;  // coefficient blocks
    float *cosine;                // the projection of cos(theta), so that E = Lambda . cosine
    int cosine_order;             // HSH hold the cosine in two bands

    struct gather_layout *irradiance_layout, *radiance_layout;
    struct gather_scratch **scratch;  // one per worker
    int scratch_count;
    uint64_t rays;
};

// R of a record as used: harmonic mean R limited by gradients and by the projected pixel
// [K05 3.3, 6.5.1].
float cache_clamp_irradiance(const struct cache *cache, const struct cache_site *site, float a,
                             struct gather_irradiance *value);
float cache_clamp_radiance(const struct cache *cache, const struct cache_site *site, float a,
                           struct gather_radiance *value);
// Neighbour clamping [K05 6.5.2]: R of the new record, after limiting it by its neighbours and them
// by it.
float cache_clamp_neighbours(struct cache_tree *tree, vec3 p, vec3 n, float R);

// Re-expresses a BRDF given in frame `from` for products with a record in frame `to`; *lobe then
// points into `turned` (3 * order^2).
void cache_turn(const struct cache *cache, const struct frame *from, const struct frame *to,
                struct cache_lobe *lobe, float *turned);

#endif
