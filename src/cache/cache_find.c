// SPDX-License-Identifier: Apache-2.0
// The records for a point, and their weights. The first records that a time limit allows may have a
// twentieth of the rays of later ones, which lie among them: each has its weight by position [K05
// (2.2)] times its number of rays, as its variance is the inverse of that.
#include "cache/cache_records.h"

float cache_rays_fraction(const struct cache *cache, enum cache_kind kind, size_t record) {
    const struct cache_store *store = &cache->store[kind];
    if (store->options.noise > 0.0f) return 1.0f;  // rays follow from variance
    const uint32_t rays = kind == CACHE_RADIANCE ? store->radiance[record].rays
                                                 : store->irradiance[record].value.rays;
    return fminf(fmaxf((float)rays, 1.0f) / (float)store->options.rays, 1.0f);
}

int cache_find(const struct cache *cache, enum cache_kind kind, vec3 p, vec3 n, float a,
               struct cache_near near[CACHE_NEAR_MAX]) {
    const struct cache_tree *tree = &cache->store[kind].tree;
    const int count = cache_tree_find(tree, p, n, a, near);
    int kept = 0;
    for (int i = 0; i < count; i++) {
        if (cache_leaks(cache, &tree->head[near[i].record], p)) continue;
        near[kept] = near[i];
        near[kept++].weight *= cache_rays_fraction(cache, kind, near[i].record);
    }
    return kept;
}
