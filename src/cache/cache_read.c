// SPDX-License-Identifier: Apache-2.0
// Reads the caches: the light of one record at a point, and the weighted mean over the records near
// it [K05 (2.2), (3.2), (3.3)]. Deviation: half of the contribution of the gradients is by their
// mean.
#include <stdlib.h>
#include <string.h>

#include "cache/cache_value.h"
#include "rsh/rsh.h"

rgb cache_rotate_irradiance(const struct cache_irradiance_value *value, vec3 n, vec3 facing) {
    const struct cache_taylor t = cache_taylor_rotate(value, n, n, facing);
    return rgb_at_least(cache_taylor_value(&t), 0.0f);
}

// Sums over the records near a point, by weight: of all of them, and of those that are oversized,
// that is much larger than they should be, as near contacts of surfaces, where the least radius
// prevents denser records.
struct disagreement {
    float weight, Y, Y2;  // Y: the luminance by single records
    float oversized, oversized_Y;
};

static void add_disagreement(struct disagreement *sum, const struct cache_taylor *t, float weight,
                             bool oversized) {
    const float Y = rgb_luminance(cache_taylor_value(t));
    sum->weight += weight;
    sum->Y += weight * Y;
    sum->Y2 += weight * Y * Y;
    if (!oversized) return;
    sum->oversized += weight;
    sum->oversized_Y += weight * Y;
}

// Whether most of the weight or of the light is of oversized records. A bright gap of less than a
// pixel, as that between a lamp and a ceiling, would throw its light beyond its ends by a record
// that has little weight there.
static bool is_oversized(const struct disagreement *sum) {
    return sum->oversized > 0.5f * sum->weight || sum->oversized_Y > 0.5f * sum->Y;
}

// Whether gathering is to replace the records. Where these are oversized, their disagreement is the
// error of interpolation, which is accepted if gathering is noisier. What a single one hides is not
// known.
static bool gathering_is_better(const struct disagreement *sum, int count, float gather_deviation) {
    const float variance = sum->weight * sum->Y2 - sqrf(sum->Y);
    return is_oversized(sum) && (count == 1 || variance > sqrf(gather_deviation * sum->Y));
}

// Adds one record to the sums; `a` is that of the options.
static void add_used(struct cache_used *used, const struct cache_head *h, float weight, float a,
                     uint32_t rays) {
    const struct cache_used one = {1, weight, weight * a * h->scale, weight * (float)rays};
    *used = cache_used_add(*used, one);
}

struct cache_used cache_irradiance(const struct cache *cache, const struct cache_lookup *at,
                                   float a, rgb *E) {
    const struct cache_tree *tree = &cache->store[CACHE_IRRADIANCE].tree;
    const float whole = cache->store[CACHE_IRRADIANCE].options.a;
    const float least = cache->options->gather_radius_ratio;
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = cache_find_to_read(cache, CACHE_IRRADIANCE, at->p, at->n, a, near);
    if (count == 0) return used;
    struct cache_taylor sum = {0};
    struct disagreement sums = {0};
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        const bool oversized =
            cache->store[CACHE_IRRADIANCE].irradiance[record].radius_ratio < least;
        const struct cache_taylor t = cache_taylor_irradiance(cache, record, at, a);
        cache_taylor_add(&sum, &t, near[i].weight);
        add_disagreement(&sums, &t, near[i].weight, oversized);
        add_used(&used, &tree->head[record], near[i].weight, whole,
                 cache->store[CACHE_IRRADIANCE].irradiance[record].value.rays);
    }
    if (gathering_is_better(&sums, count, at->gather_deviation)) return (struct cache_used){0};
    *E = cache_taylor_mean(&sum, used.weight);
    return used;
}

// Whether two frames agree so well that coefficients need no rotation.
static bool same_frame(const struct frame *a, const struct frame *b) {
    return v3_dot(a->n, b->n) > 1.0f - 1e-6f && v3_dot(a->u, b->u) > 1.0f - 1e-6f;
}

// Computes sum_k C_k (Lambda, d/dx, d/dy)_k of one record, per colour, and the sum of its noise, in
// the lanes of the record's value.
static void product(const struct cache_radiance_record *record, const struct cache_lobe *lobe,
                    float sum[CACHE_LANES]) {
    const int n2 = lobe->order * lobe->order;
    const float *v = record->value;
    for (int i = 0; i < CACHE_LANES; i++) sum[i] = 0.0f;
    if (lobe->channels == 1) {
        for (int k = 0; k < n2; k++, v += CACHE_LANES)
            for (int i = 0; i < CACHE_LANES; i++) sum[i] += lobe->C[k] * v[i];
        return;
    }
    for (int k = 0; k < n2; k++, v += CACHE_LANES) {
        const float r = lobe->C[k], g = lobe->C[n2 + k], b = lobe->C[2 * n2 + k];
        const float c[4] = {r, g, b, rgb_luminance(rgb_make(r, g, b))};
        for (int i = 0; i < CACHE_LANES; i++) sum[i] += c[i % 4] * v[i];
    }
}

// The radiance of one record that a lobe, given in the lookup's frame, reflects. *noise, if not
// NULL, is set to a sample of the noise of its luminance.
static struct cache_taylor radiance_of(const struct cache *cache, uint32_t index,
                                       const struct cache_lookup *at, float a,
                                       struct cache_lobe lobe, float *noise) {
    const struct cache_radiance_record *record = &cache->store[CACHE_RADIANCE].radiance[index];
    const struct frame *frame = &record->frame;
    float rotated[3 * RSH_MAX_COEFFICIENTS], sum[CACHE_LANES];
    if (!same_frame(&at->frame, frame)) cache_rotate(cache, &at->frame, frame, &lobe, rotated);
    product(record, &lobe, sum);
    if (noise) *noise = fabsf(sum[3]);
    const rgb rest = cache_residual_read(&record->residual, &lobe);
    struct cache_taylor t = {
        {sum[0] + rest.r, sum[1] + rest.g, sum[2] + rest.b},
        .offset = cache_taylor_offset(&cache->store[CACHE_RADIANCE].tree.head[index], at->p, a)};
    if (cache->store[CACHE_RADIANCE].options.gradients == SATIN_GRADIENTS_NONE) return t;
    for (int c = 0; c < 3; c++)
        t.grad[c] = v3_mad(v3_mul(frame->u, sum[4 + c]), sum[8 + c], frame->v);
    return t;
}

struct cache_used cache_radiance(const struct cache *cache, const struct cache_lookup *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E) {
    const struct cache_tree *tree = &cache->store[CACHE_RADIANCE].tree;
    const float whole = cache->store[CACHE_RADIANCE].options.a;
    const float least = cache->options->gather_radius_ratio;
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = cache_find_to_read(cache, CACHE_RADIANCE, at->p, at->n, a, near);
    if (count == 0) return used;
    const struct cache_lobe cosine = {
        .C = cache->cosine, .order = cache->cosine_order, .channels = 1};
    struct cache_taylor reflected = {0}, diffuse = {0};
    struct disagreement glossy_sums = {0}, diffuse_sums = {0};
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        const float w = near[i].weight;
        const bool oversized = cache->store[CACHE_RADIANCE].radiance[record].radius_ratio < least;
        struct cache_taylor t;
        if (lobe) {
            t = radiance_of(cache, record, at, a, *lobe, NULL);
            cache_taylor_add(&reflected, &t, w);
            add_disagreement(&glossy_sums, &t, w, oversized);
        }
        if (E) {
            t = radiance_of(cache, record, at, a, cosine, NULL);
            cache_taylor_add(&diffuse, &t, w);
            add_disagreement(&diffuse_sums, &t, w, oversized);
        }
        add_used(&used, &tree->head[record], w, whole,
                 cache->store[CACHE_RADIANCE].radiance[record].rays);
    }
    if (gathering_is_better(&glossy_sums, count, at->gather_deviation) ||
        gathering_is_better(&diffuse_sums, count, at->gather_deviation))
        return (struct cache_used){0};
    if (lobe) *glossy = cache_taylor_mean(&reflected, used.weight);
    if (E) *E = cache_taylor_mean(&diffuse, used.weight);
    return used;
}

bool cache_has_record_near(const struct cache *cache, vec3 p, vec3 n, float radius) {
    return cache_tree_nearest(&cache->store[CACHE_IRRADIANCE].tree, p, n, radius) >= 0 ||
           cache_tree_nearest(&cache->store[CACHE_RADIANCE].tree, p, n, radius) >= 0;
}

float cache_irradiance_reflected(const struct cache *cache, uint32_t record,
                                 const struct cache_lookup *at, float a,
                                 const struct cache_surface *surface, float *noise) {
    const struct cache_taylor t = cache_taylor_irradiance(cache, record, at, a);
    const float Y = rgb_luminance(rgb_mul(surface->diffuse, cache_taylor_value(&t)));
    const struct cache_irradiance_record *r = &cache->store[CACHE_IRRADIANCE].irradiance[record];
    *noise = Y * hypotf(r->deviation, r->gradient_deviation * v3_len(t.offset));
    return Y;
}

float cache_radiance_reflected(const struct cache *cache, uint32_t record,
                               const struct cache_lookup *at, float a,
                               const struct cache_surface *surface, float *noise) {
    const struct cache_lobe cosine = {
        .C = cache->cosine, .order = cache->cosine_order, .channels = 1};
    struct cache_taylor t;
    rgb L = rgb_grey(0.0f);
    float factor = 0.0f;
    *noise = 0.0f;
    if (surface->lobe.order) {
        t = radiance_of(cache, record, at, a, surface->lobe, &factor);
        L = rgb_mul(surface->specular, cache_taylor_value(&t));
        *noise += factor * rgb_luminance(surface->specular);
    }
    if (!rgb_black(surface->diffuse)) {
        t = radiance_of(cache, record, at, a, cosine, &factor);
        L = rgb_fma(L, surface->diffuse, cache_taylor_value(&t));
        *noise += factor * rgb_luminance(surface->diffuse);
    }
    return rgb_luminance(L);
}
