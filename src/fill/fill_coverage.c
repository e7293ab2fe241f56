// SPDX-License-Identifier: Apache-2.0
// Which sites the records cover.
#include <stdatomic.h>

#include "fill/fill_record.h"

enum { COUNTED_MOST = 4096 };  // sites that are tested for an estimate of their number

bool fill_is_covered(const struct fill *fill, enum cache_kind kind, const struct fill_sites *sites,
                     const struct fill_site *s) {
    struct cache_near near[CACHE_NEAR_MAX];
    const int count = cache_find(fill->cache, kind, s->p, s->frame.n, sites->a, near);
    for (int i = 0; i < count; i++)
        if (!(cache_rays_fraction(fill->cache, kind, near[i].record) < sites->rays_least) &&
            cache_serves(&fill->cache->store[kind].tree.head[near[i].record], s->p))
            return true;
    return false;
}

struct uncovered_count {
    const struct fill *fill;
    enum cache_kind kind;
    const struct fill_sites *sites;
    atomic_size_t found;
};

static void count_uncovered(void *ctx, size_t begin, size_t end, int worker) {
    struct uncovered_count *c = ctx;
    size_t found = 0;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct fill_site *s = &c->sites->site[i];
        if (s->kinds >> c->kind & 1u) found += !fill_is_covered(c->fill, c->kind, c->sites, s);
    }
    atomic_fetch_add(&c->found, found);
}

double fill_uncovered(const struct fill *fill, enum cache_kind kind,
                      const struct fill_sites *sites) {
    const size_t tested = sites->count < COUNTED_MOST ? sites->count : COUNTED_MOST;
    struct uncovered_count c = {fill, kind, sites, 0};
    if (!fill->cache->store[kind].filled) return 0.0;
    parallel_for_all(fill->pool, tested, 64, count_uncovered, &c);
    const double found = (double)atomic_load(&c.found);
    return tested ? found * (double)sites->count / (double)tested : 0.0;
}
