// SPDX-License-Identifier: Apache-2.0
// Removes noise from irradiance records. In a short time limit, records are few and have few rays,
// and the image reads two of them at a point, so that the noise of each shows as a blotch. Each
// record takes the mean over the records around it, extrapolated to it by their gradients, as far
// as they differ by no more than their noise explains. A record that a single ray has made bright
// has much noise by its own rays, so it is averaged, and its light is distributed to others.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "fill/fill_record.h"

enum {
    RECORDS_CHUNK = 16,  // records of a chunk
    AROUND_MOST = 256    // records that are averaged; more are left out
};
// The accuracy at which records count as near, over that at which the image reads them. With 1 the
// means of 5x5 pixels of a furnished room had as much noise as without smoothing, with 2 .64.
static const float SMOOTH_WIDER = 2.0f;
// A record's largest distance from the tangent plane of another, as in cache_tree.c.
static const float SMOOTH_SLAB = 0.4f;

struct smoothing {
    const struct cache *cache;
    const struct cache_store *store;
    struct cache_irradiance_value *value;  // the results, by record
    float limit;                           // of the error of a near record
};

// The weighted sums around one record.
struct smooth_sum {
    const struct smoothing *smoothing;
    uint32_t record;
    float Y, variance;  // of its luminance
    float weight;
    vec3 offset, rotation;
    struct cache_irradiance_value value;
    uint32_t around[AROUND_MOST];
    int count;
};

static float luminance_variance(const struct cache_irradiance_record *r) {
    return sqrf(r->deviation * rgb_luminance(r->value.E));
}

static bool is_near(const struct smooth_sum *sum, const struct cache_head *h,
                    const struct cache_head *other) {
    const float limit = sum->smoothing->limit;
    const vec3 d = v3_sub(h->p, other->p);
    return cache_tree_error(other, h->p, h->n) < limit &&
           cache_tree_error(h, other->p, other->n) < limit &&
           fabsf(v3_dot(d, other->n)) < SMOOTH_SLAB * limit * other->R &&
           fabsf(v3_dot(d, h->n)) < SMOOTH_SLAB * limit * h->R;
}

// Adds record `other`. Its gradient is applied to half of the offset, as in cache_read.c.
static void add_around(void *ctx, uint32_t other) {
    struct smooth_sum *sum = ctx;
    const struct smoothing *s = sum->smoothing;
    for (int i = 0; i < sum->count; i++)
        if (sum->around[i] == other) return;
    const struct cache_head *h = &s->store->tree.head[sum->record],
                            *from = &s->store->tree.head[other];
    if (sum->count == AROUND_MOST || !is_near(sum, h, from)) return;
    const struct cache_irradiance_record *r = &s->store->irradiance[other];
    const vec3 offset = v3_sub(h->p, from->p), rotation = v3_cross(from->n, h->n);
    const float cosine = v3_dot(from->n, h->n);
    rgb E = rgb_scale(r->value.E, cosine), change = rgb_grey(0.0f);
    float *const to[3] = {&change.r, &change.g, &change.b};
    for (int c = 0; c < 3; c++)
        *to[c] = v3_dot(offset, r->value.grad_t[c]) + v3_dot(rotation, r->value.grad_r[c]);
    float weight = (float)r->value.rays * (1.0f - cache_tree_error(from, h->p, h->n) / s->limit);
    if (other != sum->record) {
        const float difference = rgb_luminance(rgb_add(E, change)) - sum->Y;
        const float variance = sum->variance + luminance_variance(r);
        weight *= variance > 0.0f ? expf(-0.5f * sqrf(difference) / variance) : 0.0f;
        if (!(weight > 0.0f) || cache_leaks(s->cache, from, h->p)) return;
    }
    sum->around[sum->count++] = other;
    sum->weight += weight;
    sum->value.E = rgb_mad(sum->value.E, rgb_mad(E, change, 0.5f), weight);
    sum->offset = v3_mad(sum->offset, weight, offset);
    sum->rotation = v3_mad(sum->rotation, weight, rotation);
    for (int c = 0; c < 3; c++) {
        sum->value.grad_t[c] = v3_mad(sum->value.grad_t[c], weight, r->value.grad_t[c]);
        sum->value.grad_r[c] = v3_mad(sum->value.grad_r[c], weight, r->value.grad_r[c]);
    }
}

// The mean; half of the change from the mean position is by the mean gradient.
static struct cache_irradiance_value mean_around(const struct smooth_sum *sum, uint32_t rays) {
    const float inverse = 1.0f / sum->weight;
    struct cache_irradiance_value mean = {.rays = rays};
    float change[3];
    for (int c = 0; c < 3; c++) {
        mean.grad_t[c] = v3_mul(sum->value.grad_t[c], inverse);
        mean.grad_r[c] = v3_mul(sum->value.grad_r[c], inverse);
        change[c] = 0.5f * inverse *
                    (v3_dot(sum->offset, mean.grad_t[c]) + v3_dot(sum->rotation, mean.grad_r[c]));
    }
    mean.E = rgb_at_least(
        rgb_add(rgb_scale(sum->value.E, inverse), rgb_make(change[0], change[1], change[2])), 0.0f);
    return mean;
}

static void smooth_records(void *ctx, size_t begin, size_t end, int worker) {
    const struct smoothing *s = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct cache_head *h = &s->store->tree.head[i];
        const struct cache_irradiance_record *r = &s->store->irradiance[i];
        struct smooth_sum sum = {.smoothing = s, .record = (uint32_t)i};
        sum.Y = rgb_luminance(r->value.E);
        sum.variance = luminance_variance(r);
        cache_tree_visit(&s->store->tree, h->p, s->limit * h->R, add_around, &sum);
        s->value[i] = sum.weight > 0.0f ? mean_around(&sum, r->value.rays) : r->value;
    }
}

satin_status fill_smooth(struct fill *fill, float a) {
    struct cache_store *store = &fill->cache->store[CACHE_IRRADIANCE];
    const size_t count = store->tree.head_count;
    if (!store->filled || count == 0) return SATIN_OK;
    struct smoothing s = {fill->cache, store, array_new(count, sizeof *s.value), SMOOTH_WIDER * a};
    if (!s.value) return SATIN_ERROR_MEMORY;
    const bool whole = parallel_for(fill->pool, count, RECORDS_CHUNK, smooth_records, &s);
    for (size_t i = 0; whole && i < count; i++) store->irradiance[i].value = s.value[i];
    free(s.value);
    return whole ? SATIN_OK : SATIN_CANCELLED;
}
