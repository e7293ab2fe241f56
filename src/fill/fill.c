// SPDX-License-Identifier: Apache-2.0
// What makes the records of a cache: its memory, its limits and its statistics.
#include "fill/fill.h"

#include <stdlib.h>

#include "fill/fill_record.h"

static size_t most_rays(const struct fill *fill) {
    size_t most = 0;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        for (int i = 0; i < FILL_LAYOUTS; i++) {
            const struct gather_layout *layout = fill->layout[k][i];
            if (layout && gather_layout_rays(layout) > most) most = gather_layout_rays(layout);
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
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) f->radius_fraction[k] = 1.0f;
    f->irradiance_whole =
        gather_layout_new(g->options->irradiance_rays, g->options->radiance_basis, 0);
    if (!f->irradiance_whole) goto fail;
    if (fill_rays_prepare(f, CACHE_IRRADIANCE, 1.0f) != SATIN_OK) goto fail;
    if (cache->store[CACHE_RADIANCE].order &&
        fill_rays_prepare(f, CACHE_RADIANCE, 1.0f) != SATIN_OK)
        goto fail;
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
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        for (int i = 0; i < FILL_LAYOUTS; i++) gather_layout_free(fill->layout[k][i]);
    for (int i = 0; i < FILL_LAYOUTS; i++) gather_layout_free(fill->glossy[i]);
    gather_layout_free(fill->irradiance_whole);
    gather_workers_free(fill->worker, fill->worker_count);
    free(fill);
}

void fill_limit_radius(struct fill *fill, enum cache_kind kind, float fraction) {
    fill->radius_fraction[kind] = fraction;
}

void fill_statistics(const struct fill *fill, struct stats *stats) {
    cache_statistics(fill->cache, stats);
    stats_set(stats, "records.refused", (double)fill->refused);
    if (!fill->adapted.passes) return;
    stats_set(stats, "cache.passes", (double)fill->adapted.passes);
    stats_set(stats, "cache.points", (double)fill->adapted.points);
    stats_set(stats, "cache.shrunk", (double)fill->adapted.shrunk);
    stats_set(stats, "cache.overhead_s", fill->adapted.seconds);
}
