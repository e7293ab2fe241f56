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

static bool insert(struct cache *cache, enum cache_kind kind, const struct cache_head *head,
                   const void *record, uint32_t rays) {
    struct cache_store *store = &cache->store[kind];
    const size_t next = store->tree.head_count, size = store->record_bytes;
    if (!array_reserve(&store->record, &store->capacity, next + 1, size)) return false;
    memcpy((char *)store->record + next * size, record, size);
    if (!cache_tree_insert(&store->tree, head)) return false;
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

typedef bool copy_fn(struct cache *cache, const struct cache_head *head,
                     const struct cache_store *from, size_t i);

static bool copy_irradiance(struct cache *cache, const struct cache_head *head,
                            const struct cache_store *from, size_t i) {
    return cache_insert_irradiance(cache, head, &from->irradiance[i]);
}

static bool copy_radiance(struct cache *cache, const struct cache_head *head,
                          const struct cache_store *from, size_t i) {
    struct cache_radiance_record record = from->radiance[i];
    float *value = cache_value_new(cache);
    if (!value) return false;
    memcpy(value, record.value, (size_t)(from->order * from->order * CACHE_LANES) * sizeof *value);
    record.value = value;
    return cache_insert_radiance(cache, head, &record);
}

static copy_fn *const copy_of[CACHE_KINDS] = {
    [CACHE_IRRADIANCE] = copy_irradiance,
    [CACHE_RADIANCE] = copy_radiance,
};

bool cache_insert_copy(struct cache *cache, const struct cache *from, enum cache_kind kind,
                       size_t i) {
    const struct cache_store *store = &from->store[kind];
    return copy_of[kind](cache, &store->tree.head[i], store, i);
}
