// SPDX-License-Identifier: Apache-2.0
// Removes noise from irradiance records. In a short time limit, records are few and have few rays,
// and the image reads two of them at a point, so that the noise of each shows as a blotch. Each
// record takes the mean over the records around it, extrapolated to it by their gradients, as far
// as they differ by no more than their noise explains. A record that a single ray has made bright
// has much noise by its own rays, so it is averaged, and its light is distributed to others.
//
// Among records of many rays only such bright ones show. They alone take the mean of those around
// them, and what they have more is distributed.
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

// An outlier is a record of a larger relative deviation. One whose brightest ray is a quarter of
// its light has more than that; in scenes at draft, 0 to 9 of some hundreds have.
static const float OUTLIER_DEVIATION = 0.2f;
// The factor of the accuracy at which records take light of an outlier. A single ray of such light
// stands for a large area: with 2, 4 and 8, a block of pixels with an outlier of three times its
// light was 1.6, 1.24 and 1.13 times too bright.
static const float SPREAD_WIDER = 4.0f;
// The most light that an outlier gives away, over its mean. Where it is more, that light is far too
// rare for so few rays: without the limit, single rays made a quarter of an image of glass ten
// times too bright. The larger the number of rays, the rarer is the light that is lost.
static const float SPREAD_MOST = 1.0f;

struct smoothing {
    const struct cache *cache;
    const struct cache_store *store;
    struct cache_irradiance_value *value;  // the results, by record
    float limit;                           // the accuracy at which records are near
    rgb *given;                            // by record: what outliers give to it
};

// The weighted sums around one record.
struct smooth_sum {
    const struct smoothing *smoothing;
    uint32_t record;
    bool without;            // the record itself
    struct cache_lookup at;  // the record's point
    float Y, variance;       // of its luminance
    float weight;
    struct cache_taylor all;
    uint32_t around[AROUND_MOST];
    float of[AROUND_MOST];  // their weights
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
    if (other == sum->record && sum->without) return;
    if (other != sum->record) {
        const float difference = rgb_luminance(cache_taylor_value(&t)) - sum->Y;
        const float variance = sum->variance + luminance_variance(r);
        weight *= variance > 0.0f ? expf(-0.5f * sqrf(difference) / variance) : 0.0f;
        if (!(weight > 0.0f) || cache_leaks(s->cache, from, h->p)) return;
    }
    sum->of[sum->count] = weight;
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

// Sums over the records around one, with or `without` itself.
static void sum_around(const struct smoothing *s, uint32_t record, bool without,
                       struct smooth_sum *sum) {
    const struct cache_head *h = &s->store->tree.head[record];
    const struct cache_irradiance_record *r = &s->store->irradiance[record];
    sum->smoothing = s;
    sum->record = record;
    sum->without = without;
    sum->at = (struct cache_lookup){.p = h->p, .n = h->n, .frame = frame_from_normal(h->n)};
    sum->Y = rgb_luminance(r->value.E);
    sum->variance = luminance_variance(r);
    sum->weight = 0.0f;
    sum->all = (struct cache_taylor){0};
    sum->count = 0;
    cache_tree_visit(&s->store->tree, h->p, s->limit * h->R, add_around, sum);
}

static void smooth_records(void *ctx, size_t begin, size_t end, int worker) {
    const struct smoothing *s = ctx;
    (void)worker;
    struct smooth_sum sum;
    for (size_t i = begin; i < end; i++) {
        const struct cache_irradiance_record *r = &s->store->irradiance[i];
        sum_around(s, (uint32_t)i, false, &sum);
        s->value[i] = sum.weight > 0.0f ? mean_around(&sum, r->value.rays) : r->value;
    }
}

// Gives an outlier the mean of the records around it, and all of them its further light.
static void spread_outlier(const struct smoothing *s, uint32_t record) {
    const struct cache_irradiance_value *from = &s->store->irradiance[record].value;
    struct smooth_sum sum;
    sum_around(s, record, true, &sum);
    if (sum.count == 0) return;
    const struct cache_irradiance_value mean = mean_around(&sum, from->rays);
    const float Y = rgb_luminance(mean.E), excess = sum.Y - Y, weight = (float)from->rays;
    if (!(excess > 0.0f)) return;
    s->value[record] = mean;
    const float kept = fminf(1.0f, SPREAD_MOST * Y / excess);
    const rgb given = rgb_scale(rgb_sub(from->E, mean.E), kept / (sum.weight + weight));
    s->given[record] = rgb_mad(s->given[record], given, weight);
    for (int i = 0; i < sum.count; i++)
        s->given[sum.around[i]] = rgb_mad(s->given[sum.around[i]], given, sum.of[i]);
}

// Adds light to a record. Where it takes the colour of others away, none remains less than 0.
static void add_given(struct cache_irradiance_value *value, rgb given) {
    const rgb E = rgb_add(value->E, given);
    value->E = rgb_make(fmaxf(E.r, 0.0f), fmaxf(E.g, 0.0f), fmaxf(E.b, 0.0f));
}

satin_status fill_spread_outliers(struct fill *fill, float a) {
    struct cache_store *store = &fill->cache->store[CACHE_IRRADIANCE];
    const size_t count = store->tree.head_count;
    size_t outliers = 0;
    for (size_t i = 0; i < count; i++)
        if (store->irradiance[i].deviation > OUTLIER_DEVIATION) outliers++;
    fill->outliers = outliers;
    if (outliers == 0) return SATIN_OK;
    struct smoothing s = {.cache = fill->cache, .store = store, .limit = SPREAD_WIDER * a};
    s.value = array_new(count, sizeof *s.value);
    s.given = array_new(count, sizeof *s.given);
    const bool memory = s.value && s.given;
    for (size_t i = 0; memory && i < count; i++) s.value[i] = store->irradiance[i].value;
    for (size_t i = 0; memory && i < count; i++)
        if (store->irradiance[i].deviation > OUTLIER_DEVIATION) spread_outlier(&s, (uint32_t)i);
    for (size_t i = 0; memory && i < count; i++) {
        store->irradiance[i].value = s.value[i];
        add_given(&store->irradiance[i].value, s.given[i]);
    }
    free(s.value);
    free(s.given);
    return memory ? SATIN_OK : SATIN_ERROR_MEMORY;
}

satin_status fill_smooth(struct fill *fill, float a) {
    struct cache_store *store = &fill->cache->store[CACHE_IRRADIANCE];
    const size_t count = store->tree.head_count;
    if (!store->filled || count == 0) return SATIN_OK;
    struct smoothing s = {.cache = fill->cache, .store = store, .limit = SMOOTH_WIDER * a};
    s.value = array_new(count, sizeof *s.value);
    if (!s.value) return SATIN_ERROR_MEMORY;
    const struct parallel_results values = {.slot = {{s.value, sizeof *s.value}}};
    const bool whole =
        parallel_for_results(fill->pool, count, RECORDS_CHUNK, smooth_records, &s, &values);
    for (size_t i = 0; whole && i < count; i++) store->irradiance[i].value = s.value[i];
    free(s.value);
    return whole ? SATIN_OK : SATIN_CANCELLED;
}
