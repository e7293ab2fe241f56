// SPDX-License-Identifier: Apache-2.0
// Adds records to the caches: the value to the array of its kind, and the head to the octree, at
// the same index.
#include <string.h>

#include "base/array.h"
#include "cache/cache_records.h"

float *cache_value_new(struct cache *cache) {
    const int order = cache->store[CACHE_RADIANCE].order;
    return arena_array(&cache->radiance_arena, (size_t)(order * order * CACHE_LANES),
                       sizeof(float));
}

// The array of the records of one kind.
struct record_array {
    void **record;
    size_t *capacity, size;  // size: bytes of a record
};

static struct record_array array_of(struct cache *c, enum cache_kind kind) {
    if (kind == CACHE_IRRADIANCE)
        return (struct record_array){(void **)&c->irradiance, &c->irradiance_capacity,
                                     sizeof *c->irradiance};
    return (struct record_array){(void **)&c->radiance, &c->radiance_capacity, sizeof *c->radiance};
}

static bool insert(struct cache *cache, enum cache_kind kind, const struct cache_head *head,
                   const void *record, uint32_t rays) {
    struct cache_tree *tree = &cache->store[kind].tree;
    const struct record_array array = array_of(cache, kind);
    const size_t next = tree->head_count;
    if (!array_reserve(array.record, array.capacity, next + 1, array.size)) return false;
    memcpy((char *)*array.record + next * array.size, record, array.size);
    if (!cache_tree_insert(tree, head)) return false;
    cache->rays += rays;
    return true;
}

bool cache_insert_irradiance(struct cache *cache, const struct cache_head *head,
                             const struct cache_irradiance_record *record) {
    return insert(cache, CACHE_IRRADIANCE, head, record, record->value.rays);
}

bool cache_insert_radiance(struct cache *cache, const struct cache_head *head,
                           const struct cache_radiance_record *record) {
    return insert(cache, CACHE_RADIANCE, head, record, record->rays);
}
