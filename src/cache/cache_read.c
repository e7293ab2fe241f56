// SPDX-License-Identifier: Apache-2.0
// Reading the caches: what one record says of a place, and the weighted mean of those that are near
// [K05 (2.2), (3.2), (3.3)].
#include <stdlib.h>
#include <string.h>

#include "cache/cache_records.h"
#include "rsh/rsh.h"

// The records to interpolate at a place; where none is, the nearest one.
static int find(const struct cache *cache, const struct cache_tree *tree,
                const struct cache_place *at, float a, struct cache_near near[CACHE_NEAR_MAX]) {
    int count = cache_find(cache, tree, at->p, at->n, a, near);
    if (count > 0 || !(at->reach > 0.0f)) return count;
    int64_t nearest = cache_tree_nearest(tree, at->p, at->n, at->reach);
    if (nearest < 0 || cache_leaks(cache, &tree->head[nearest], at->p)) return 0;
    near[0] = (struct cache_near){(uint32_t)nearest, 1.0f};
    return 1;
}

// The way from a record to p, cut at the radius within which its gradient is good.
static vec3 way_from(const struct cache_head *h, vec3 p, float a) {
    vec3 d = v3_sub(p, h->p);
    float length = v3_len(d), most = a * h->R;
    return length > most ? v3_mul(d, most / length) : d;
}

// E of one record at a place. A facet that is turned by an angle t sees E cos t, and what the
// rotation gradient adds sin t.
static rgb irradiance_of(const struct cache *cache, uint32_t record, const struct cache_place *at,
                         float a) {
    const struct cache_head *h = &cache->irradiance_tree.head[record];
    const struct gather_irradiance *value = &cache->irradiance[record].value;
    const bool gradients = cache->g->options->irradiance_gradients != SATIN_GRADIENTS_NONE;
    const float share = minf(v3_dot(at->n, at->frame.n), 1.0f);
    const vec3 move = way_from(h, at->p, a), turn = v3_cross(h->n, at->frame.n);
    float e[3] = {share * value->E.r, share * value->E.g, share * value->E.b};
    for (int c = 0; c < 3; c++) {
        if (gradients) e[c] += v3_dot(turn, value->grad_r[c]) + v3_dot(move, value->grad_t[c]);
        e[c] = fmaxf(e[c], 0.0f);
    }
    return rgb_make(e[0], e[1], e[2]);
}

// Whether most of the weight is of records that reach much farther than they should: near contacts,
// where none could be placed densely enough.
static bool crowded(const struct cache *cache, enum cache_kind kind, const struct cache_near *near,
                    int count) {
    const float least = cache->g->options->gather_room;
    float sum = 0.0f, weights = 0.0f;
    for (int i = 0; i < count; i++) {
        float room = kind == CACHE_IRRADIANCE ? cache->irradiance[near[i].record].room
                                              : cache->radiance[near[i].record].room;
        if (room < least) sum += near[i].weight;
        weights += near[i].weight;
    }
    return sum > 0.5f * weights;
}

// Counts one more record; `a` is the options'.
static void use(struct cache_used *used, const struct cache_head *h, float weight, float a,
                uint32_t rays) {
    const struct cache_used one = {1, weight, weight * a * h->scale, weight * (float)rays};
    *used = cache_used_add(*used, one);
}

struct cache_used cache_irradiance(const struct cache *cache, const struct cache_place *at, float a,
                                   rgb *E) {
    const struct cache_tree *tree = &cache->irradiance_tree;
    const float whole = cache->g->options->irradiance_a;
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = find(cache, tree, at, a, near);
    if (count == 0 || crowded(cache, CACHE_IRRADIANCE, near, count)) return used;
    rgb sum = rgb_grey(0.0f);
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        sum = rgb_mad(sum, irradiance_of(cache, record, at, a), near[i].weight);
        use(&used, &tree->head[record], near[i].weight, whole,
            cache->irradiance[record].value.rays);
    }
    *E = rgb_scale(sum, 1.0f / used.weight);
    return used;
}

// Whether two frames agree so well that no coefficient needs turning.
static bool same_frame(const struct frame *a, const struct frame *b) {
    return v3_dot(a->n, b->n) > 1.0f - 1e-6f && v3_dot(a->u, b->u) > 1.0f - 1e-6f;
}

// sum_k C_k (Lambda + dx d/dx + dy d/dy)_k of one record, per colour, and its noise.
static void product(const struct cache_radiance_record *record, const struct cache_lobe *lobe,
                    float dx, float dy, float out[4]) {
    const int n2 = lobe->order * lobe->order;
    float sum[CACHE_LANES] = {0};
    const float *v = record->value;
    if (lobe->channels == 1) {
        for (int k = 0; k < n2; k++, v += CACHE_LANES)
            for (int i = 0; i < CACHE_LANES; i++) sum[i] += lobe->C[k] * v[i];
    } else {
        for (int k = 0; k < n2; k++, v += CACHE_LANES) {
            const float r = lobe->C[k], g = lobe->C[n2 + k], b = lobe->C[2 * n2 + k];
            const float c[4] = {r, g, b, rgb_luminance(rgb_make(r, g, b))};
            for (int i = 0; i < CACHE_LANES; i++) sum[i] += c[i % 4] * v[i];
        }
    }
    for (int c = 0; c < 3; c++) out[c] = sum[c] + dx * sum[4 + c] + dy * sum[8 + c];
    out[3] = fabsf(sum[3]);
}

// What a lobe, given in the place's frame, reflects of one record; *noise, if not NULL, gets that
// of its luminance.
static rgb radiance_of(const struct cache *cache, uint32_t index, const struct cache_place *at,
                       float a, struct cache_lobe lobe, float *noise) {
    const struct cache_radiance_record *record = &cache->radiance[index];
    const float on = cache->g->options->radiance_gradients != SATIN_GRADIENTS_NONE ? 1.0f : 0.0f;
    const vec3 d = way_from(&cache->radiance_tree.head[index], at->p, a);
    float turned[3 * RSH_MAX_COEFFICIENTS], value[4];
    if (!same_frame(&at->frame, &record->frame))
        cache_turn(cache, &at->frame, &record->frame, &lobe, turned);
    product(record, &lobe, on * v3_dot(d, record->frame.u), on * v3_dot(d, record->frame.v), value);
    if (noise) *noise = value[3];
    return rgb_make(value[0], value[1], value[2]);
}

static rgb not_negative(rgb x) {
    return rgb_make(fmaxf(x.r, 0.0f), fmaxf(x.g, 0.0f), fmaxf(x.b, 0.0f));
}

struct cache_used cache_radiance(const struct cache *cache, const struct cache_place *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E) {
    const struct cache_tree *tree = &cache->radiance_tree;
    const float whole = cache->g->options->radiance_a;
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = find(cache, tree, at, a, near);
    if (count == 0 || crowded(cache, CACHE_RADIANCE, near, count)) return used;
    const struct cache_lobe cosine = {cache->cosine, cache->cosine_order, 1};
    rgb shine = rgb_grey(0.0f), diffuse = shine;
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        const float w = near[i].weight;
        if (lobe) shine = rgb_mad(shine, radiance_of(cache, record, at, a, *lobe, NULL), w);
        if (E) diffuse = rgb_mad(diffuse, radiance_of(cache, record, at, a, cosine, NULL), w);
        use(&used, &tree->head[record], w, whole, cache->radiance[record].rays);
    }
    if (lobe) *glossy = not_negative(rgb_scale(shine, 1.0f / used.weight));
    if (E) *E = not_negative(rgb_scale(diffuse, 1.0f / used.weight));
    return used;
}

bool cache_stands(const struct cache *cache, vec3 p, vec3 n, float reach) {
    return cache_tree_nearest(&cache->irradiance_tree, p, n, reach) >= 0 ||
           cache_tree_nearest(&cache->radiance_tree, p, n, reach) >= 0;
}

float cache_reflected(const struct cache *cache, enum cache_kind kind, uint32_t record,
                      const struct cache_place *at, float a, const struct cache_surface *surface,
                      float *noise) {
    rgb L = rgb_grey(0.0f);
    *noise = 0.0f;
    if (kind == CACHE_IRRADIANCE) {
        float Y = rgb_luminance(rgb_mul(surface->diffuse, irradiance_of(cache, record, at, a)));
        *noise = cache->irradiance[record].deviation * Y;
        return Y;
    }
    const struct cache_lobe cosine = {cache->cosine, cache->cosine_order, 1};
    float part = 0.0f;
    if (surface->lobe.order) {
        L = rgb_mul(surface->specular, radiance_of(cache, record, at, a, surface->lobe, &part));
        *noise += part * rgb_luminance(surface->specular);
    }
    if (!rgb_black(surface->diffuse)) {
        L = rgb_fma(L, surface->diffuse, radiance_of(cache, record, at, a, cosine, &part));
        *noise += part * rgb_luminance(surface->diffuse);
    }
    return rgb_luminance(L);
}
