// SPDX-License-Identifier: Apache-2.0
// Adaptive caching [K05 6.3, 6.4]. A record's own accuracy, a times its scale, is lowered where its
// light at a shading point differs perceptibly from that of the other records, and new records fill
// the gaps, until there is no such difference at any point. A pass evaluates all queued points on
// all threads against the unchanged records, lowers the scales to the least that a point requires,
// fills the gaps, and queues the points that are affected. So nothing depends on the order of the
// points or on the threads.
#include <stdlib.h>

#include "base/array.h"
#include "base/stats.h"
#include "fill/fill_adaptive_cache.h"

enum {
    PASSES_MAX = 11,  // the thesis needed no more
    CHUNK_POINTS = 256
};

// A record that is shrunk for a point ends before it by this fraction of the distance.
static const float SHORT_OF = 1e-4f;

static void evaluate_points(void *ctx, size_t begin, size_t end, int worker) {
    struct fill_adaptation *c = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct fill_point *p = &c->point[i];
        if (!p->queued) continue;
        fill_update_point(c, c->site[i], p);
        fill_evaluate_point(c, c->site[i], p);
    }
}

// Shrinks records so that they end before the points for which they are to be shrunk.
static void shrink(struct fill_adaptation *c) {
    for (size_t i = 0; i < c->count; i++) {
        struct fill_point *p = &c->point[i];
        if (!p->queued || !p->shrinking) continue;
        for (int k = 0; k < p->count; k++) {
            if (!(p->shrinking >> k & 1u)) continue;
            struct cache_head *h = &c->tree->head[p->with[k].record];
            h->scale = fminf(h->scale, p->with[k].error * (1.0f - SHORT_OF) / c->read_a);
        }
    }
}

// Adds a record to the contributions of a point. If the list is full, it replaces the worst one.
static void add_contribution(struct fill_adaptation *c, const struct fill_site *s,
                             struct fill_point *p, uint32_t record) {
    struct fill_contribution x = {record, c->change[record],
                                  cache_tree_error(&c->tree->head[record], s->p, s->frame.n), -1.0f,
                                  0.0f};
    int at = p->count;
    if (at == FILL_CONTRIBUTIONS) {
        at = 0;
        for (int i = 1; i < FILL_CONTRIBUTIONS; i++)
            if (p->with[i].error > p->with[at].error) at = i;
        if (p->with[at].error <= x.error) return;
    } else {
        p->count++;
    }
    p->with[at] = x;
}

// Queues the points at which records were added or shrunk, and adds the new records to their
// contributions.
static void queue_points(void *ctx, size_t begin, size_t end, int worker) {
    struct fill_adaptation *c = ctx;
    (void)worker;
    struct cache_near near[CACHE_NEAR_MAX];
    for (size_t i = begin; i < end; i++) {
        struct fill_point *p = &c->point[i];
        const struct fill_site *s = c->site[i];
        p->queued = cache_tree_covered(&c->shrunk, s->p, s->frame.n, c->read_a);
        int count = cache_tree_find(&c->added, s->p, s->frame.n, c->read_a, near);
        for (int k = 0; k < count; k++) {
            uint32_t record = near[k].record + (uint32_t)c->records;
            if (cache_leaks(c->cache, &c->tree->head[record], s->p)) continue;
            add_contribution(c, s, p, record);
            p->queued = true;
        }
    }
}

// Stores the radii and scales of all records. Records that were added or shrunk since the last call
// are put into separate trees. False if there is no memory.
static bool note_changes(struct fill_adaptation *c) {
    const size_t before = c->records, now = c->tree->head_count;
    const struct satin_scene *scene = c->cache->scene;
    cache_tree_free(&c->added);
    cache_tree_free(&c->shrunk);
    cache_tree_init(&c->added, scene->bounds_lo, scene->bounds_hi);
    cache_tree_init(&c->shrunk, scene->bounds_lo, scene->bounds_hi);
    if (!array_reserve((void **)&c->change, &c->capacity[0], now, sizeof *c->change) ||
        !array_reserve((void **)&c->R, &c->capacity[1], now, sizeof *c->R) ||
        !array_reserve((void **)&c->scale, &c->capacity[2], now, sizeof *c->scale))
        return false;
    for (size_t i = 0; i < now; i++) {
        struct cache_head h = c->tree->head[i];
        bool fresh = i >= before, changed = !fresh && (h.R < c->R[i] || h.scale < c->scale[i]);
        if (changed) {
            struct cache_head before_it = h;
            before_it.R = c->R[i];
            before_it.scale = c->scale[i];
            if (!cache_tree_insert(&c->shrunk, &before_it)) return false;
            c->change[i]++;
            c->fill->adapted.shrunk++;
        }
        if (fresh) {
            if (!cache_tree_insert(&c->added, &h)) return false;
            c->change[i] = 0;
        }
        c->R[i] = h.R;
        c->scale[i] = h.scale;
    }
    return true;
}

// Makes new records at points that have lost their last one.
static satin_status fill_gaps(struct fill_adaptation *c) {
    size_t gaps = 0;
    for (size_t i = 0; i < c->count; i++) {
        struct fill_point *p = &c->point[i];
        if (!p->queued) continue;
        fill_update_point(c, c->site[i], p);
        gaps += p->bare;
    }
    if (gaps == 0) return SATIN_OK;
    struct fill_site *site = array_new(gaps, sizeof *site);
    if (!site) return SATIN_ERROR_MEMORY;
    size_t n = 0;
    for (size_t i = 0; i < c->count; i++) {
        if (!c->point[i].queued || !c->point[i].bare) continue;
        site[n++] = *c->site[i];
    }
    struct fill_sites sites = *c->sites;
    sites.site = site;
    sites.count = n;
    sites.adapted = true;
    satin_status status = fill_records(c->fill, c->kind, &sites);
    free(site);
    return status;
}

// So that a pass that was stopped leaves no gaps.
static satin_status undo_shrinking(struct fill_adaptation *c, satin_status status) {
    for (size_t i = 0; i < c->records; i++) c->tree->head[i].scale = c->scale[i];
    return status;
}

static satin_status adapt_records(struct fill_adaptation *c) {
    struct parallel *pool = c->fill->pool;
    int pass = 0;
    // At the beginning all records are new to all points.
    if (!note_changes(c)) return SATIN_ERROR_MEMORY;
    c->records = 0;
    for (; pass < PASSES_MAX; pass++) {
        double start = stats_wall();
        if (!parallel_for(pool, c->count, CHUNK_POINTS, queue_points, c)) return SATIN_CANCELLED;
        c->records = c->tree->head_count;
        size_t queued = 0;
        for (size_t i = 0; i < c->count; i++) queued += c->point[i].queued;
        if (queued == 0) break;
        c->fill->adapted.points += queued;
        if (!parallel_for(pool, c->count, CHUNK_POINTS, evaluate_points, c)) return SATIN_CANCELLED;
        shrink(c);
        for (size_t i = 0; i < c->records; i++)  // so that the points are updated
            if (c->tree->head[i].scale < c->scale[i]) c->change[i]++;
        double gather = stats_wall();
        satin_status status = fill_gaps(c);
        if (status != SATIN_OK) return undo_shrinking(c, status);
        double note = stats_wall();
        if (!note_changes(c)) return SATIN_ERROR_MEMORY;
        c->fill->adapted.seconds += gather - start + (stats_wall() - note);
    }
    if (c->fill->adapted.passes < pass) c->fill->adapted.passes = pass;
    return SATIN_OK;
}

satin_status fill_adapt(struct fill *fill, enum cache_kind kind, const struct fill_sites *sites,
                        float read_a) {
    struct fill_adaptation c = {.fill = fill,
                                .cache = fill->cache,
                                .sites = sites,
                                .kind = kind,
                                .tree = &fill->cache->store[kind].tree,
                                .read_a = read_a};
    c.site = array_new(sites->count, sizeof(struct fill_site *));
    c.point = array_new(sites->count, sizeof *c.point);
    satin_status status = SATIN_ERROR_MEMORY;
    if (c.site && c.point) {
        for (size_t i = 0; i < sites->count; i++)
            if (sites->site[i].kinds >> kind & 1u) c.site[c.count++] = &sites->site[i];
        const char *part = parallel_begin_part(fill->pool, "adapt");
        status = c.count ? adapt_records(&c) : SATIN_OK;
        parallel_begin_part(fill->pool, part);
    }
    free(c.site);
    free(c.point);
    free(c.change);
    free(c.R);
    free(c.scale);
    cache_tree_free(&c.added);
    cache_tree_free(&c.shrunk);
    return status;
}
