// SPDX-License-Identifier: Apache-2.0
// The caches: creation, reading [K05 (2.2), (3.2), (3.3)], statistics. Filling is in cache_fill.c.
#include "cache/cache.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "cache/cache_records.h"
#include "rsh/rsh.h"

// Projection of cos(theta) over the hemisphere by the midpoint rule: E is then Lambda . cosine.
static void project_cosine(float *out, satin_basis basis, int order) {
    enum { ROWS = 4096 };
    float y[RSH_MAX_ORDER * RSH_MAX_ORDER];
    memset(out, 0, sizeof *out * (size_t)(order * order));
    for (int l = 0; l < order; l++) {
        double sum = 0.0;
        for (int j = 0; j < ROWS; j++) {
            double z = (j + 0.5) / ROWS;
            float w[3] = {(float)sqrt(1.0 - z * z), 0.0f, (float)z};
            rsh_eval(basis == SATIN_HSH ? RSH_HEMISPHERE : RSH_SPHERE, order, w, y);
            sum += z * (double)y[l * (l + 1)];
        }
        out[l * (l + 1)] = (float)(2.0 * 3.14159265358979323846 * sum / ROWS);
    }
}

struct cache *cache_new(const struct gather *g, int order, struct parallel *pool) {
    struct cache *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    const satin_options *o = g->options;
    c->g = g;
    c->pool = pool;
    c->order = order;
    cache_tree_init(&c->irradiance_tree, g->scene->bounds_lo, g->scene->bounds_hi);
    cache_tree_init(&c->radiance_tree, g->scene->bounds_lo, g->scene->bounds_hi);
    c->irradiance_layout = gather_layout_new(o->irradiance_rays, o->radiance_basis, 0);
    if (!c->irradiance_layout) goto fail;
    size_t rays = gather_layout_rays(c->irradiance_layout);
    if (order) {
        c->radiance_layout = gather_layout_new(o->radiance_rays, o->radiance_basis, order);
        c->cosine_order = o->radiance_basis == SATIN_HSH && order > 2 ? 2 : order;
        c->cosine = array_new((size_t)(c->cosine_order * c->cosine_order), sizeof *c->cosine);
        if (!c->radiance_layout || !c->cosine) goto fail;
        project_cosine(c->cosine, o->radiance_basis, c->cosine_order);
        if (gather_layout_rays(c->radiance_layout) > rays)
            rays = gather_layout_rays(c->radiance_layout);
    }
    c->scratch_count = parallel_threads(pool);
    c->scratch = calloc((size_t)c->scratch_count, sizeof *c->scratch);
    if (!c->scratch) goto fail;
    for (int i = 0; i < c->scratch_count; i++)
        if (!(c->scratch[i] = gather_scratch_new(rays))) goto fail;
    return c;
fail:
    cache_free(c);
    return NULL;
}

void cache_free(struct cache *cache) {
    if (!cache) return;
    cache_tree_free(&cache->irradiance_tree);
    cache_tree_free(&cache->radiance_tree);
    free(cache->irradiance);
    free(cache->radiance);
    arena_free(&cache->radiance_arena);
    free(cache->cosine);
    gather_layout_free(cache->irradiance_layout);
    gather_layout_free(cache->radiance_layout);
    for (int i = 0; cache->scratch && i < cache->scratch_count; i++)
        gather_scratch_free(cache->scratch[i]);
    free(cache->scratch);
    free(cache);
}

// The records to interpolate at a place.
static int find(const struct cache_tree *tree, const struct cache_place *at, float a,
                struct cache_near near[CACHE_NEAR_MAX]) {
    int count = cache_tree_find(tree, at->p, at->n, a, near);
    if (count > 0 || !(at->reach > 0.0f)) return count;
    int64_t nearest = cache_tree_nearest(tree, at->p, at->n, at->reach);
    if (nearest < 0) return 0;
    near[0] = (struct cache_near){(uint32_t)nearest, 1.0f};
    return 1;
}

// The way from a record to p, cut at the radius within which its gradient is good.
static vec3 way_from(const struct cache_head *h, vec3 p, float a) {
    vec3 d = v3_sub(p, h->p);
    float length = v3_len(d), most = a * h->R;
    return length > most ? v3_mul(d, most / length) : d;
}

// A facet that is turned by an angle t sees E cos t, and what the rotation gradient adds sin t.
int cache_irradiance(const struct cache *cache, const struct cache_place *at, float a, rgb *E) {
    struct cache_near near[CACHE_NEAR_MAX];
    int count = find(&cache->irradiance_tree, at, a, near);
    if (count == 0) return 0;
    const vec3 facing = at->frame.n;
    const bool gradients = cache->g->options->irradiance_gradients != SATIN_GRADIENTS_NONE;
    const float share = minf(v3_dot(at->n, facing), 1.0f);
    float sum[3] = {0}, weights = 0.0f;
    for (int i = 0; i < count; i++) {
        const struct cache_head *h = &cache->irradiance_tree.head[near[i].record];
        const struct gather_irradiance *value = &cache->irradiance[near[i].record];
        const float Ei[3] = {value->E.r, value->E.g, value->E.b};
        vec3 move = way_from(h, at->p, a), turn = v3_cross(h->n, facing);
        float w = near[i].weight;
        for (int c = 0; c < 3; c++) {
            float e = share * Ei[c];
            if (gradients) e += v3_dot(turn, value->grad_r[c]) + v3_dot(move, value->grad_t[c]);
            sum[c] += w * fmaxf(e, 0.0f);
        }
        weights += w;
    }
    *E = rgb_make(sum[0] / weights, sum[1] / weights, sum[2] / weights);
    return count;
}

// Whether two frames agree so well that no coefficient needs turning.
static bool same_frame(const struct frame *a, const struct frame *b) {
    return v3_dot(a->n, b->n) > 1.0f - 1e-6f && v3_dot(a->u, b->u) > 1.0f - 1e-6f;
}

// sum_k C_k (Lambda + dx d/dx + dy d/dy)_k of one record, per colour.
static void product(const struct cache_radiance_record *record, const struct cache_lobe *lobe,
                    float dx, float dy, float out[3]) {
    const int n2 = lobe->order * lobe->order;
    float sum[CACHE_LANES] = {0};
    const float *v = record->value;
    if (lobe->channels == 1) {
        for (int k = 0; k < n2; k++, v += CACHE_LANES)
            for (int i = 0; i < CACHE_LANES; i++) sum[i] += lobe->C[k] * v[i];
    } else {
        for (int k = 0; k < n2; k++, v += CACHE_LANES) {
            const float c[4] = {lobe->C[k], lobe->C[n2 + k], lobe->C[2 * n2 + k], 0.0f};
            for (int i = 0; i < CACHE_LANES; i++) sum[i] += c[i % 4] * v[i];
        }
    }
    for (int c = 0; c < 3; c++) out[c] = sum[c] + dx * sum[4 + c] + dy * sum[8 + c];
}

// Adds w times what the lobe, given in `frame`, reflects of the record displaced by (dx, dy).
static void add_product(const struct cache *cache, const struct cache_radiance_record *record,
                        const struct frame *frame, struct cache_lobe lobe, const float move[2],
                        float w, float sum[3]) {
    float turned[3 * RSH_MAX_COEFFICIENTS], value[3];
    if (!same_frame(frame, &record->frame)) cache_turn(cache, frame, &record->frame, &lobe, turned);
    product(record, &lobe, move[0], move[1], value);
    for (int c = 0; c < 3; c++) sum[c] += w * value[c];
}

int cache_radiance(const struct cache *cache, const struct cache_place *at, float a,
                   const struct cache_lobe *lobe, rgb *glossy, rgb *E) {
    struct cache_near near[CACHE_NEAR_MAX];
    int count = find(&cache->radiance_tree, at, a, near);
    if (count == 0) return 0;
    const bool gradients = cache->g->options->radiance_gradients != SATIN_GRADIENTS_NONE;
    const float on = gradients ? 1.0f : 0.0f;
    const struct cache_lobe cosine = {cache->cosine, cache->cosine_order, 1};
    float shine[3] = {0}, diffuse[3] = {0}, weights = 0.0f;
    for (int i = 0; i < count; i++) {
        const struct cache_radiance_record *record = &cache->radiance[near[i].record];
        vec3 d = way_from(&cache->radiance_tree.head[near[i].record], at->p, a);
        const float move[2] = {on * v3_dot(d, record->frame.u), on * v3_dot(d, record->frame.v)};
        if (lobe) add_product(cache, record, &at->frame, *lobe, move, near[i].weight, shine);
        if (E) add_product(cache, record, &at->frame, cosine, move, near[i].weight, diffuse);
        weights += near[i].weight;
    }
    if (lobe)
        *glossy = rgb_make(fmaxf(shine[0] / weights, 0.0f), fmaxf(shine[1] / weights, 0.0f),
                           fmaxf(shine[2] / weights, 0.0f));
    if (E)
        *E = rgb_make(fmaxf(diffuse[0] / weights, 0.0f), fmaxf(diffuse[1] / weights, 0.0f),
                      fmaxf(diffuse[2] / weights, 0.0f));
    return count;
}

size_t cache_count(const struct cache *cache, enum cache_kind kind) {
    return kind == CACHE_IRRADIANCE ? cache->irradiance_tree.head_count
                                    : cache->radiance_tree.head_count;
}

void cache_record(const struct cache *cache, enum cache_kind kind, size_t i, vec3 *p, vec3 *n,
                  float *R) {
    const struct cache_tree *tree =
        kind == CACHE_IRRADIANCE ? &cache->irradiance_tree : &cache->radiance_tree;
    *p = tree->head[i].p;
    *n = tree->head[i].n;
    *R = tree->head[i].R;
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
    stats_set(stats, "records.bytes",
              tree_bytes(&cache->irradiance_tree) + tree_bytes(&cache->radiance_tree) +
                  (double)(cache->irradiance_capacity * sizeof *cache->irradiance) +
                  (double)(cache->radiance_capacity * sizeof *cache->radiance) +
                  (double)cache->radiance_arena.bytes);
}
