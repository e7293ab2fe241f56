// SPDX-License-Identifier: Apache-2.0
// The caches: creation and statistics.
#include "cache/cache.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"
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
            rsh_eval(brdf_rsh_basis(basis), order, w, y);
            sum += z * (double)y[l * (l + 1)];
        }
        out[l * (l + 1)] = (float)(2.0 * 3.14159265358979323846 * sum / CACHE_ROWS);
    }
}

// The options that both kinds of records have, which satin_options names irradiance_a, radiance_a
// and so on.
#define OPTIONS_OF(o, kind)                                                                   \
    {                                                                                         \
        .cache = (o)->kind##_cache, .a = (o)->kind##_a, .widen = (o)->kind##_widen,           \
        .rays = (o)->kind##_rays, .noise = (o)->kind##_noise, .basis = (o)->radiance_basis,   \
        .gradients = (o)->kind##_gradients, .radius = (o)->kind##_radius,                     \
        .gradient_clamp = (o)->kind##_gradient_clamp,                                         \
        .neighbour_clamp = (o)->kind##_neighbour_clamp, .min_pixels = (o)->kind##_min_pixels, \
        .max_pixels = (o)->kind##_max_pixels, .max_radius = (o)->record_max_radius            \
    }

void cache_options_of(const satin_options *o, struct cache_options out[CACHE_KINDS]) {
    out[CACHE_IRRADIANCE] = (struct cache_options)OPTIONS_OF(o, irradiance);
    out[CACHE_RADIANCE] = (struct cache_options)OPTIONS_OF(o, radiance);
    out[CACHE_RADIANCE].diffuse = o->radiance_cache && o->radiance_diffuse;
    out[CACHE_RADIANCE].curvature_clamp = o->radiance_curvature_clamp;
}
#undef OPTIONS_OF

// A record none of whose rays meets anything has no radius of its own. Of a ring on a wide table,
// the first such records took the whole image, and no light of the ring was left in one of ten
// drafts. So the influence radius of irradiance records is a fraction of the film at most, or some
// pixels. That makes no difference to the number of records elsewhere
// (docs/experiments/cache-errors.md).
#define FILM_FRACTION 0.125f
#define FILM_PIXELS 8.0f
static float limit_pixels(const struct satin_scene *scene, float most) {
    const int width = scene->film.width, height = scene->film.height;
    const float film = fmaxf(FILM_FRACTION * (float)(width > height ? width : height), FILM_PIXELS);
    return isfinite(most) ? fminf(most, film) : most;  // records of further bounces have no pixels
}

struct cache *cache_new(const struct satin_scene *scene, const satin_options *options, int order) {
    struct cache *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->scene = scene;
    c->options = options;
    struct cache_options of[CACHE_KINDS];
    cache_options_of(options, of);
    of[CACHE_IRRADIANCE].max_pixels = limit_pixels(scene, of[CACHE_IRRADIANCE].max_pixels);
    c->store[CACHE_IRRADIANCE] = (struct cache_store){
        .filled = true, .record_bytes = sizeof(struct cache_irradiance_record)};
    c->store[CACHE_RADIANCE] = (struct cache_store){
        .filled = order > 0, .order = order, .record_bytes = sizeof(struct cache_radiance_record)};
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        c->store[k].options = of[k];
        cache_tree_init(&c->store[k].tree, scene->bounds_lo, scene->bounds_hi);
    }
    if (!order) return c;
    c->cosine_order = options->radiance_basis == SATIN_HSH && order > 2 ? 2 : order;
    c->cosine = array_new((size_t)(c->cosine_order * c->cosine_order), sizeof *c->cosine);
    if (!c->cosine) {
        cache_free(c);
        return NULL;
    }
    project_cosine(c->cosine, options->radiance_basis, c->cosine_order);
    return c;
}

void cache_free(struct cache *cache) {
    if (!cache) return;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        cache_tree_free(&cache->store[k].tree);
        free(cache->store[k].record);
    }
    arena_free(&cache->radiance_arena);
    free(cache->cosine);
    free(cache);
}

size_t cache_count(const struct cache *cache, enum cache_kind kind) {
    return cache->store[kind].tree.head_count;
}

size_t cache_count_all(const struct cache *cache) {
    return cache_count(cache, CACHE_IRRADIANCE) + cache_count(cache, CACHE_RADIANCE);
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

double cache_bytes(const struct cache *cache) {
    double bytes = (double)cache->radiance_arena.bytes;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        const struct cache_store *store = &cache->store[k];
        bytes += tree_bytes(&store->tree) + (double)(store->capacity * store->record_bytes);
    }
    return bytes;
}

void cache_limit(struct cache *cache, double bytes) { cache->bytes_most = bytes; }

bool cache_full(const struct cache *cache) {
    return cache->bytes_most > 0.0 && cache_bytes(cache) >= cache->bytes_most;
}

uint64_t cache_rays(const struct cache *cache) { return cache->rays; }

void cache_statistics(const struct cache *cache, struct stats *stats) {
    stats_set(stats, "records.irradiance", (double)cache_count(cache, CACHE_IRRADIANCE));
    stats_set(stats, "records.radiance", (double)cache_count(cache, CACHE_RADIANCE));
    stats_set(stats, "records.rays", (double)cache->rays);
    stats_set(stats, "records.bytes", cache_bytes(cache));
}
