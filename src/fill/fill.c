// SPDX-License-Identifier: Apache-2.0
// What makes the records of a cache: its memory, its limits and its statistics.
#include "fill/fill.h"

#include <stdlib.h>

#include "fill/fill_record.h"

static size_t layout_rays(const struct gather_layout *layout) {
    return layout ? gather_layout_rays(layout) : 0;
}

// The largest number of rays of a record without those to clusters. Where glossy lobes draw rays,
// they draw as many as there are stratified ones, which even of the fewest rays are 8.
static size_t most_rays(const struct fill *fill) {
    size_t most = 0;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        for (int i = 0; i < FILL_LAYOUTS; i++) {
            const size_t stratified = layout_rays(fill->side[k].layout[i]);
            const size_t glossy = 2 * layout_rays(fill->side[k].glossy[i]);
            if (stratified > most) most = stratified;
            if (glossy > most) most = glossy;
        }
    return most;
}

struct fill *fill_new(struct cache *cache, const struct gather *g, struct parallel *pool) {
    struct fill *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    f->cache = cache;
    f->g = g;
    f->pool = pool;
    f->rays_fraction = 1.0f;
    const struct cache_store *irradiance = &cache->store[CACHE_IRRADIANCE];
    f->side[CACHE_IRRADIANCE].whole =
        gather_layout_new(irradiance->options.rays, irradiance->options.basis, irradiance->order);
    if (!f->side[CACHE_IRRADIANCE].whole) goto fail;
    f->side[CACHE_RADIANCE].draws_glossy = true;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        f->side[k].radius_fraction = 1.0f;
        if (cache->store[k].filled && fill_rays_prepare(f, k, 1.0f) != SATIN_OK) goto fail;
    }
    f->worker_count = parallel_threads(pool);
    f->worker = gather_workers_new(pool, most_rays(f));
    if (!f->worker) goto fail;
    return f;
fail:
    fill_free(f);
    return NULL;
}

void fill_free(struct fill *fill) {
    if (!fill) return;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        struct fill_side *side = &fill->side[k];
        for (int i = 0; i < FILL_LAYOUTS; i++) gather_layout_free(side->layout[i]);
        for (int i = 0; i < FILL_LAYOUTS; i++) gather_layout_free(side->glossy[i]);
        gather_layout_free(side->whole);
    }
    gather_workers_free(fill->worker, fill->worker_count);
    free(fill);
}

void fill_limit_radius(struct fill *fill, enum cache_kind kind, float fraction) {
    fill->side[kind].radius_fraction = fraction;
}

void fill_statistics(const struct fill *fill, struct stats *stats) {
    cache_statistics(fill->cache, stats);
    stats_set(stats, "records.refused", (double)fill->refused);
    stats_set(stats, "records.outliers", (double)fill->outliers);
    if (!fill->adapted.passes) return;
    stats_set(stats, "cache.passes", (double)fill->adapted.passes);
    stats_set(stats, "cache.points", (double)fill->adapted.points);
    stats_set(stats, "cache.shrunk", (double)fill->adapted.shrunk);
    stats_set(stats, "cache.overhead_s", fill->adapted.seconds);
}
