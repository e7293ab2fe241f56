// SPDX-License-Identifier: Apache-2.0
// The caches: creation and statistics.
#include "cache/cache.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "cache/cache_records.h"
#include "rsh/rsh.h"

// Projects cos(theta) over the hemisphere by the midpoint rule: E is then Lambda . cosine.
static void project_cosine(float *out, satin_basis basis, int order) {
    enum { CACHE_ROWS = 4096 };
    float y[RSH_MAX_ORDER * RSH_MAX_ORDER];
    memset(out, 0, sizeof *out * (size_t)(order * order));
    for (int l = 0; l < order; l++) {
        double sum = 0.0;
        for (int j = 0; j < CACHE_ROWS; j++) {
            double z = (j + 0.5) / CACHE_ROWS;
            float w[3] = {(float)sqrt(1.0 - z * z), 0.0f, (float)z};
            rsh_eval(basis == SATIN_HSH ? RSH_HEMISPHERE : RSH_SPHERE, order, w, y);
            sum += z * (double)y[l * (l + 1)];
        }
        out[l * (l + 1)] = (float)(2.0 * 3.14159265358979323846 * sum / CACHE_ROWS);
    }
}

struct cache_options cache_options_of(const satin_options *o, enum cache_kind kind) {
    if (kind == CACHE_IRRADIANCE)
        return (struct cache_options){.a = o->irradiance_a,
                                      .widen = o->irradiance_widen,
                                      .rays = o->irradiance_rays,
                                      .noise = o->irradiance_noise,
                                      .basis = o->radiance_basis,
                                      .gradients = o->irradiance_gradients,
                                      .radius = o->irradiance_radius,
                                      .gradient_clamp = o->irradiance_gradient_clamp,
                                      .neighbour_clamp = o->irradiance_neighbour_clamp,
                                      .min_pixels = o->irradiance_min_pixels,
                                      .max_pixels = o->irradiance_max_pixels,
                                      .max_radius = o->record_max_radius};
    return (struct cache_options){.a = o->radiance_a,
                                  .widen = o->radiance_widen,
                                  .rays = o->radiance_rays,
                                  .noise = o->radiance_noise,
                                  .basis = o->radiance_basis,
                                  .gradients = o->radiance_gradients,
                                  .radius = o->radiance_radius,
                                  .gradient_clamp = o->radiance_gradient_clamp,
                                  .neighbour_clamp = o->radiance_neighbour_clamp,
                                  .min_pixels = o->radiance_min_pixels,
                                  .max_pixels = o->radiance_max_pixels,
                                  .max_radius = o->record_max_radius};
}

static size_t most_rays(const struct cache *cache) {
    size_t most = 0;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        for (int i = 0; i < CACHE_LAYOUTS; i++) {
            const struct gather_layout *layout = cache->store[k].layout[i];
            if (layout && gather_layout_rays(layout) > most) most = gather_layout_rays(layout);
        }
    return most;
}

struct cache *cache_new(const struct gather *g, int order, struct parallel *pool) {
    struct cache *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    const satin_options *o = g->options;
    c->g = g;
    c->pool = pool;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        c->store[k].options = cache_options_of(o, k);
        cache_tree_init(&c->store[k].tree, g->scene->bounds_lo, g->scene->bounds_hi);
    }
    c->store[CACHE_RADIANCE].order = order;
    c->rays_fraction = 1.0f;
    c->irradiance_whole = gather_layout_new(o->irradiance_rays, o->radiance_basis, 0);
    if (!c->irradiance_whole) goto fail;
    if (cache_rays_prepare(c, CACHE_IRRADIANCE, 1.0f) != SATIN_OK) goto fail;
    if (order) {
        c->cosine_order = o->radiance_basis == SATIN_HSH && order > 2 ? 2 : order;
        c->cosine = array_new((size_t)(c->cosine_order * c->cosine_order), sizeof *c->cosine);
        if (!c->cosine) goto fail;
        if (cache_rays_prepare(c, CACHE_RADIANCE, 1.0f) != SATIN_OK) goto fail;
        project_cosine(c->cosine, o->radiance_basis, c->cosine_order);
    }
    c->worker_count = parallel_threads(pool);
    c->worker = gather_workers_new(pool, most_rays(c));
    if (!c->worker) goto fail;
    return c;
fail:
    cache_free(c);
    return NULL;
}

void cache_free(struct cache *cache) {
    if (!cache) return;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        cache_tree_free(&cache->store[k].tree);
        for (int i = 0; i < CACHE_LAYOUTS; i++) gather_layout_free(cache->store[k].layout[i]);
    }
    free(cache->irradiance);
    free(cache->radiance);
    arena_free(&cache->radiance_arena);
    free(cache->cosine);
    gather_layout_free(cache->irradiance_whole);
    gather_workers_free(cache->worker, cache->worker_count);
    free(cache);
}

void cache_limit_radius(struct cache *cache, enum cache_kind kind, float fraction) {
    cache->store[kind].options.min_pixels =
        fraction * cache_options_of(cache->g->options, kind).min_pixels;
}

size_t cache_count(const struct cache *cache, enum cache_kind kind) {
    return cache->store[kind].tree.head_count;
}

void cache_record(const struct cache *cache, enum cache_kind kind, size_t i, vec3 *p, vec3 *n,
                  float *R) {
    const struct cache_head *head = &cache->store[kind].tree.head[i];
    *p = head->p;
    *n = head->n;
    *R = head->R;
}

static double tree_bytes(const struct cache_tree *t) {
    return (double)(t->head_capacity * sizeof *t->head + t->node_capacity * sizeof *t->node +
                    t->ref_capacity * sizeof *t->ref);
}

uint64_t cache_rays(const struct cache *cache) { return cache->rays; }

void cache_statistics(const struct cache *cache, struct stats *stats) {
    stats_set(stats, "records.irradiance", (double)cache_count(cache, CACHE_IRRADIANCE));
    stats_set(stats, "records.radiance", (double)cache_count(cache, CACHE_RADIANCE));
    stats_set(stats, "records.rays", (double)cache->rays);
    stats_set(stats, "records.refused", (double)cache->refused);
    stats_set(stats, "records.bytes",
              tree_bytes(&cache->store[CACHE_IRRADIANCE].tree) +
                  tree_bytes(&cache->store[CACHE_RADIANCE].tree) +
                  (double)(cache->irradiance_capacity * sizeof *cache->irradiance) +
                  (double)(cache->radiance_capacity * sizeof *cache->radiance) +
                  (double)cache->radiance_arena.bytes);
    if (!cache->adapted.passes) return;
    stats_set(stats, "cache.passes", (double)cache->adapted.passes);
    stats_set(stats, "cache.points", (double)cache->adapted.points);
    stats_set(stats, "cache.shrunk", (double)cache->adapted.shrunk);
    stats_set(stats, "cache.overhead_s", cache->adapted.seconds);
}
