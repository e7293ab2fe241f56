// SPDX-License-Identifier: Apache-2.0
// Adds records to the caches: the value to the array of its kind, and the head to the octree, at
// the same index.
#include "base/array.h"
#include "cache/cache_records.h"

float *cache_value_new(struct cache *cache) {
    const int order = cache->store[CACHE_RADIANCE].order;
    return arena_array(&cache->radiance_arena, (size_t)(order * order * CACHE_LANES),
                       sizeof(float));
}

bool cache_insert_irradiance(struct cache *cache, const struct cache_head *head,
                             const struct cache_irradiance_record *record) {
    struct cache_tree *tree = &cache->store[CACHE_IRRADIANCE].tree;
    const size_t next = tree->head_count;
    if (!array_reserve((void **)&cache->irradiance, &cache->irradiance_capacity, next + 1,
                       sizeof *cache->irradiance))
        return false;
    cache->irradiance[next] = *record;
    if (!cache_tree_insert(tree, head)) return false;
    cache->rays += record->value.rays;
    return true;
}

bool cache_insert_radiance(struct cache *cache, const struct cache_head *head,
                           const struct cache_radiance_record *record) {
    struct cache_tree *tree = &cache->store[CACHE_RADIANCE].tree;
    const size_t next = tree->head_count;
    if (!array_reserve((void **)&cache->radiance, &cache->radiance_capacity, next + 1,
                       sizeof *cache->radiance))
        return false;
    cache->radiance[next] = *record;
    if (!cache_tree_insert(tree, head)) return false;
    cache->rays += record->rays;
    return true;
}
