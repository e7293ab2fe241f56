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

struct smoothing {
    const struct cache *cache;
    const struct cache_store *store;
    struct cache_irradiance_value *value;  // the results, by record
    float limit;                           // the accuracy at which records are near
};

// The weighted sums around one record.
struct smooth_sum {
    const struct smoothing *smoothing;
    uint32_t record;
    struct cache_lookup at;  // the record's point
    float Y, variance;       // of its luminance
    float weight;
    struct cache_taylor all;
    uint32_t around[AROUND_MOST];
    int count;
};

static float luminance_variance(const struct cache_irradiance_record *r) {
    return sqrf(r->deviation * rgb_luminance(r->value.E));
}

static void add_around(void *ctx, uint32_t other) {
    struct smooth_sum *sum = ctx;
    const struct smoothing *s = sum->smoothing;
    for (int i = 0; i < sum->count; i++)
        if (sum->around[i] == other) return;
    const struct cache_head *h = &s->store->tree.head[sum->record],
                            *from = &s->store->tree.head[other];
    float weight = cache_tree_weight(from, h->p, h->n, s->limit);
    if (sum->count == AROUND_MOST || !(weight > 0.0f) ||
        !(cache_tree_weight(h, from->p, from->n, s->limit) > 0.0f))
        return;
    const struct cache_irradiance_record *r = &s->store->irradiance[other];
    const struct cache_taylor t = cache_taylor_irradiance(s->cache, other, &sum->at, s->limit);
    weight *= (float)r->value.rays;
    if (other != sum->record) {
        const float difference = rgb_luminance(cache_taylor_value(&t)) - sum->Y;
        const float variance = sum->variance + luminance_variance(r);
        weight *= variance > 0.0f ? expf(-0.5f * sqrf(difference) / variance) : 0.0f;
        if (!(weight > 0.0f) || cache_leaks(s->cache, from, h->p)) return;
    }
    sum->around[sum->count++] = other;
    sum->weight += weight;
    cache_taylor_add(&sum->all, &t, weight);
}

static struct cache_irradiance_value mean_around(const struct smooth_sum *sum, uint32_t rays) {
    const float inverse = 1.0f / sum->weight;
    struct cache_irradiance_value mean = {.E = cache_taylor_mean(&sum->all, sum->weight),
                                          .rays = rays};
    for (int c = 0; c < 3; c++) {
        mean.grad_t[c] = v3_mul(sum->all.grad[c], inverse);
        mean.grad_r[c] = v3_mul(sum->all.rotation_grad[c], inverse);
    }
    return mean;
}

static void smooth_records(void *ctx, size_t begin, size_t end, int worker) {
    const struct smoothing *s = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct cache_head *h = &s->store->tree.head[i];
        const struct cache_irradiance_record *r = &s->store->irradiance[i];
        struct smooth_sum sum = {.smoothing = s,
                                 .record = (uint32_t)i,
                                 .at = {.p = h->p, .n = h->n, .frame = frame_from_normal(h->n)}};
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
