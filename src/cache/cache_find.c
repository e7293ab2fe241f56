// SPDX-License-Identifier: Apache-2.0
// The records for a point, and their weights. The first records that a time limit allows may have a
// twentieth of the rays of later ones, which lie among them: each has its weight by position [K05
// (2.2)] times its number of rays, as its variance is the inverse of that. Where records are dense,
// those close by suffice: a point that has more weight of records than PLENTY reads them at a
// smaller accuracy a, by which it has that weight, but at no less than CLOSEST times a.
#include "cache/cache_records.h"

#include <math.h>

// Measured in docs/experiments/record-placement.md.
static const float PLENTY = 4.0f, CLOSEST = 0.5f;
enum { CLOSER_STEPS = 4 };

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

// Records near a point: the fractions of their rays, and their errors over a.
struct near_records {
    int count;
    float rays[CACHE_NEAR_MAX], error[CACHE_NEAR_MAX];
};

// The weight of all records at `fraction` times a.
static float weight_at(const struct near_records *records, float fraction) {
    const float scale = 1.0f / fraction;
    float sum = 0.0f;
    for (int i = 0; i < records->count; i++)
        sum += records->rays[i] * maxf(1.0f - scale * records->error[i], 0.0f);
    return sum;
}

// The fraction of a at which the records have the weight PLENTY, by halves and then a straight line
// that keeps it continuous.
static float closer_fraction(const struct near_records *records, float whole) {
    float lo = CLOSEST, hi = 1.0f, of_lo = weight_at(records, lo), of_hi = whole;
    if (of_lo >= PLENTY) return lo;
    for (int step = 0; step < CLOSER_STEPS; step++) {
        const float middle = 0.5f * (lo + hi), weight = weight_at(records, middle);
        if (weight < PLENTY)
            lo = middle, of_lo = weight;
        else
            hi = middle, of_hi = weight;
    }
    return lo + (hi - lo) * (PLENTY - of_lo) / (of_hi - of_lo);
}

int cache_find_close(const struct cache *cache, enum cache_kind kind, vec3 p, vec3 n, float a,
                     struct cache_near near[CACHE_NEAR_MAX]) {
    struct near_records records = {.count = cache_find(cache, kind, p, n, a, near)};
    float whole = 0.0f;
    for (int i = 0; i < records.count; i++) whole += near[i].weight;
    if (whole <= PLENTY) return records.count;
    for (int i = 0; i < records.count; i++) {
        records.rays[i] = cache_rays_fraction(cache, kind, near[i].record);
        records.error[i] = 1.0f - near[i].weight / records.rays[i];
    }
    const float fraction = closer_fraction(&records, whole);
    int kept = 0;
    for (int i = 0; i < records.count; i++) {
        const float weight = records.rays[i] * (1.0f - records.error[i] / fraction);
        if (weight > 0.0f) near[kept++] = (struct cache_near){near[i].record, weight};
    }
    return kept;
}
