// SPDX-License-Identifier: Apache-2.0
// The records for a point, and their weights. The first records that a time limit allows may have a
// twentieth of the rays of later ones, which lie among them: each has its weight by position [K05
// (2.2)] times its number of rays, as its variance is the inverse of that. Where records are dense,
// those close by suffice: a point that has more weight of records than PLENTY reads them at a
// smaller accuracy a, by which it has that weight, but at no less than CLOSEST times a. And with a
// time limit that ends before records overlap, their discs would show: a point that has less
// weight by position than THIN reads records at a larger a, but at no more than CACHE_WIDER times.
#include "cache/cache_records.h"

#include <math.h>

// Measured in docs/experiments/record-placement.md.
static const float PLENTY = 4.0f, CLOSEST = 0.5f, THIN = 0.5f;
enum { CLOSER_STEPS = 4 };  // of the search for that accuracy

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

// Records near a point: the fractions of their rays, and their errors over the accuracy at which
// they were found.
struct near_records {
    int count;
    float rays[CACHE_NEAR_MAX], error[CACHE_NEAR_MAX];
};

static void note_errors(const struct cache *cache, enum cache_kind kind,
                        const struct cache_near *near, int count, struct near_records *out) {
    out->count = count;
    for (int i = 0; i < count; i++) {
        out->rays[i] = cache_rays_fraction(cache, kind, near[i].record);
        out->error[i] = 1.0f - near[i].weight / out->rays[i];
    }
}

// The weight of all records at `fraction` of that accuracy.
static float weight_at(const struct near_records *records, float fraction) {
    const float scale = 1.0f / fraction;
    float sum = 0.0f;
    for (int i = 0; i < records->count; i++)
        sum += records->rays[i] * maxf(1.0f - scale * records->error[i], 0.0f);
    return sum;
}

// The fraction of at least `lo` at which the records, whose weight is `whole` at 1, have the weight
// `wanted`, by halves and then a straight line that keeps it continuous.
static float fraction_for(const struct near_records *records, float wanted, float lo, float whole) {
    float hi = 1.0f, of_lo = weight_at(records, lo), of_hi = whole;
    if (of_lo >= wanted) return lo;
    if (of_hi <= wanted) return hi;
    for (int step = 0; step < CLOSER_STEPS; step++) {
        const float middle = 0.5f * (lo + hi), weight = weight_at(records, middle);
        if (weight < wanted)
            lo = middle, of_lo = weight;
        else
            hi = middle, of_hi = weight;
    }
    return lo + (hi - lo) * (wanted - of_lo) / (of_hi - of_lo);
}

// Keeps the records that are near at that fraction. Returns their number.
static int keep_at(const struct near_records *records, float fraction,
                   struct cache_near near[CACHE_NEAR_MAX]) {
    int kept = 0;
    for (int i = 0; i < records->count; i++) {
        const float weight = records->rays[i] * (1.0f - records->error[i] / fraction);
        if (weight > 0.0f) near[kept++] = (struct cache_near){near[i].record, weight};
    }
    return kept;
}

// Gives each record the weight of all rays.
static struct near_records as_if_whole(struct near_records records) {
    for (int i = 0; i < records.count; i++) records.rays[i] = 1.0f;
    return records;
}

// Reads `count` records, found at a, at a larger accuracy if they are few.
static int find_wider(const struct cache *cache, enum cache_kind kind, vec3 p, vec3 n, float a,
                      int count, struct cache_near near[CACHE_NEAR_MAX]) {
    struct near_records records;
    note_errors(cache, kind, near, count, &records);
    struct near_records whole = as_if_whole(records);
    if (weight_at(&whole, 1.0f) >= THIN) return count;
    note_errors(cache, kind, near, cache_find(cache, kind, p, n, CACHE_WIDER * a, near), &records);
    whole = as_if_whole(records);
    const float fraction = fraction_for(&whole, THIN, 1.0f / CACHE_WIDER, weight_at(&whole, 1.0f));
    return keep_at(&records, fraction, near);
}

int cache_find_to_read(const struct cache *cache, enum cache_kind kind, vec3 p, vec3 n, float a,
                       struct cache_near near[CACHE_NEAR_MAX]) {
    const int count = cache_find(cache, kind, p, n, a, near);
    float weight = 0.0f;
    for (int i = 0; i < count; i++) weight += near[i].weight;
    if (weight < THIN && cache->store[kind].widens)
        return find_wider(cache, kind, p, n, a, count, near);
    if (weight <= PLENTY) return count;
    struct near_records records;
    note_errors(cache, kind, near, count, &records);
    return keep_at(&records, fraction_for(&records, PLENTY, CLOSEST, weight), near);
}
