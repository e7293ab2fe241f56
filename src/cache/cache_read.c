// SPDX-License-Identifier: Apache-2.0
// Reads the caches: the light of one record at a point, and the weighted mean over the records near
// it [K05 (2.2), (3.2), (3.3)]. Deviation: half of the contribution of the gradients is by their
// mean.
#include <stdlib.h>
#include <string.h>

#include "cache/cache_value.h"
#include "rsh/rsh.h"

// Finds the records to interpolate at a point, or the nearest record if there are none.
static int find_or_nearest(const struct cache *cache, const struct cache_tree *tree,
                           const struct cache_lookup *at, float a,
                           struct cache_near near[CACHE_NEAR_MAX]) {
    int count = cache_find(cache, tree, at->p, at->n, a, near);
    if (count > 0 || !(at->fallback_radius > 0.0f)) return count;
    int64_t nearest = cache_tree_nearest(tree, at->p, at->n, at->fallback_radius);
    if (nearest < 0 || cache_leaks(cache, &tree->head[nearest], at->p)) return 0;
    near[0] = (struct cache_near){(uint32_t)nearest, 1.0f};
    return 1;
}

// The offset from a record to p, limited to the length for which the record's gradient is valid.
static vec3 offset_from(const struct cache_head *h, vec3 p, float a) {
    vec3 d = v3_sub(p, h->p);
    float length = v3_len(d), most = a * h->R;
    return length > most ? v3_mul(d, most / length) : d;
}

// A record's value and gradients, and the offset and rotation from it to the point. Also used for
// weighted sums of these.
struct taylor {
    float value[3];
    vec3 offset, grad[3];             // on the surface
    vec3 rotation, rotation_grad[3];  // of the normal
};

static float by_gradients(const struct taylor *t, int c) {
    return v3_dot(t->offset, t->grad[c]) + v3_dot(t->rotation, t->rotation_grad[c]);
}

// The value at the point from this record alone.
static rgb value_alone(const struct taylor *t) {
    return rgb_make(t->value[0] + by_gradients(t, 0), t->value[1] + by_gradients(t, 1),
                    t->value[2] + by_gradients(t, 2));
}

// A value that is extrapolated by its gradient has an error of half the second derivative times the
// squared distance; the mean of values without gradients has the opposite error. So each record's
// gradient is applied to half of its offset, and the mean gradient to half of the mean offset: if
// records surround the point, errors of second order cancel.
static void add_record(struct taylor *sum, const struct taylor *t, float weight) {
    for (int c = 0; c < 3; c++) {
        sum->value[c] += weight * (t->value[c] + 0.5f * by_gradients(t, c));
        sum->grad[c] = v3_mad(sum->grad[c], weight, t->grad[c]);
        sum->rotation_grad[c] = v3_mad(sum->rotation_grad[c], weight, t->rotation_grad[c]);
    }
    sum->offset = v3_mad(sum->offset, weight, t->offset);
    sum->rotation = v3_mad(sum->rotation, weight, t->rotation);
}

static rgb mean_value(const struct taylor *sum, float weight) {
    const float inverse = 1.0f / weight, half = 0.5f * inverse * inverse;
    float mean[3];
    for (int c = 0; c < 3; c++)
        mean[c] = at_least(inverse * sum->value[c] + half * by_gradients(sum, c), 0.0f);
    return rgb_make(mean[0], mean[1], mean[2]);
}

// E on a facet that is rotated from the normal n to `facing`, where E and its rotation gradient are
// those of the normal `from`.
static struct taylor rotate_value(const struct cache_irradiance_value *value, vec3 from, vec3 n,
                                  vec3 facing) {
    const float cosine = minf(v3_dot(n, facing), 1.0f);
    struct taylor t = {{cosine * value->E.r, cosine * value->E.g, cosine * value->E.b},
                       .rotation = v3_cross(from, facing)};
    for (int c = 0; c < 3; c++) t.rotation_grad[c] = value->grad_r[c];
    return t;
}

rgb cache_rotate_irradiance(const struct cache_irradiance_value *value, vec3 n, vec3 facing) {
    const struct taylor t = rotate_value(value, n, n, facing);
    return rgb_at_least(value_alone(&t), 0.0f);
}

// E of one record at a point, on a facet that bumps rotate.
static struct taylor irradiance_of(const struct cache *cache, uint32_t record,
                                   const struct cache_lookup *at, float a) {
    const struct cache_head *h = &cache->store[CACHE_IRRADIANCE].tree.head[record];
    const struct cache_irradiance_value *value =
        &cache->store[CACHE_IRRADIANCE].irradiance[record].value;
    struct taylor t = rotate_value(value, h->n, at->n, at->frame.n);
    t.offset = offset_from(h, at->p, a);
    const bool gradients = cache->store[CACHE_IRRADIANCE].options.gradients != SATIN_GRADIENTS_NONE;
    for (int c = 0; c < 3; c++) {
        t.grad[c] = gradients ? value->grad_t[c] : v3(0, 0, 0);
        if (!gradients) t.rotation_grad[c] = v3(0, 0, 0);
    }
    return t;
}

// Returns radius_ratio of a record, see fill_extent.
typedef float ratio_fn(const struct cache *cache, uint32_t record);
static float irradiance_ratio(const struct cache *cache, uint32_t record) {
    return cache->store[CACHE_IRRADIANCE].irradiance[record].radius_ratio;
}
static float radiance_ratio(const struct cache *cache, uint32_t record) {
    return cache->store[CACHE_RADIANCE].radiance[record].radius_ratio;
}

// Whether most of the weight is of records that are much larger than they should be, as near
// contacts of surfaces, where the least radius prevents denser records.
static bool is_oversized(const struct cache *cache, ratio_fn *ratio, const struct cache_near *near,
                         int count) {
    const float least = cache->options->gather_radius_ratio;
    float sum = 0.0f, weights = 0.0f;
    for (int i = 0; i < count; i++) {
        if (ratio(cache, near[i].record) < least) sum += near[i].weight;
        weights += near[i].weight;
    }
    return sum > 0.5f * weights;
}

// The luminance by single records, weighted sums.
struct disagreement {
    float weight, Y, Y2;
};

static void add_disagreement(struct disagreement *sum, const struct taylor *t, float weight) {
    const float Y = rgb_luminance(value_alone(t));
    sum->weight += weight;
    sum->Y += weight * Y;
    sum->Y2 += weight * Y * Y;
}

// Where records are oversized, their disagreement is the error of interpolation. It is accepted if
// gathering is noisier.
static bool disagreement_exceeds(const struct disagreement *sum, float gather_deviation) {
    const float variance = sum->weight * sum->Y2 - sqrf(sum->Y);
    return variance > sqrf(gather_deviation * sum->Y);
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
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = find_or_nearest(cache, tree, at, a, near);
    if (count == 0) return used;
    struct taylor sum = {0};
    struct disagreement sums = {0};
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        const struct taylor t = irradiance_of(cache, record, at, a);
        add_record(&sum, &t, near[i].weight);
        add_disagreement(&sums, &t, near[i].weight);
        add_used(&used, &tree->head[record], near[i].weight, whole,
                 cache->store[CACHE_IRRADIANCE].irradiance[record].value.rays);
    }
    if (is_oversized(cache, irradiance_ratio, near, count) &&
        (count == 1 || disagreement_exceeds(&sums, at->gather_deviation)))
        return (struct cache_used){0};
    *E = mean_value(&sum, used.weight);
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
static struct taylor radiance_of(const struct cache *cache, uint32_t index,
                                 const struct cache_lookup *at, float a, struct cache_lobe lobe,
                                 float *noise) {
    const struct cache_radiance_record *record = &cache->store[CACHE_RADIANCE].radiance[index];
    const struct frame *frame = &record->frame;
    float rotated[3 * RSH_MAX_COEFFICIENTS], sum[CACHE_LANES];
    if (!same_frame(&at->frame, frame)) cache_rotate(cache, &at->frame, frame, &lobe, rotated);
    product(record, &lobe, sum);
    if (noise) *noise = fabsf(sum[3]);
    const rgb rest = cache_residual_read(&record->residual, &lobe);
    struct taylor t = {
        {sum[0] + rest.r, sum[1] + rest.g, sum[2] + rest.b},
        .offset = offset_from(&cache->store[CACHE_RADIANCE].tree.head[index], at->p, a)};
    if (cache->store[CACHE_RADIANCE].options.gradients == SATIN_GRADIENTS_NONE) return t;
    for (int c = 0; c < 3; c++)
        t.grad[c] = v3_mad(v3_mul(frame->u, sum[4 + c]), sum[8 + c], frame->v);
    return t;
}

struct cache_used cache_radiance(const struct cache *cache, const struct cache_lookup *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E) {
    const struct cache_tree *tree = &cache->store[CACHE_RADIANCE].tree;
    const float whole = cache->store[CACHE_RADIANCE].options.a;
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = find_or_nearest(cache, tree, at, a, near);
    if (count == 0) return used;
    const struct cache_lobe cosine = {
        .C = cache->cosine, .order = cache->cosine_order, .channels = 1};
    struct taylor reflected = {0}, diffuse = {0};
    struct disagreement glossy_sums = {0}, diffuse_sums = {0};
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        const float w = near[i].weight;
        struct taylor t;
        if (lobe) {
            t = radiance_of(cache, record, at, a, *lobe, NULL);
            add_record(&reflected, &t, w);
            add_disagreement(&glossy_sums, &t, w);
        }
        if (E) {
            t = radiance_of(cache, record, at, a, cosine, NULL);
            add_record(&diffuse, &t, w);
            add_disagreement(&diffuse_sums, &t, w);
        }
        add_used(&used, &tree->head[record], w, whole,
                 cache->store[CACHE_RADIANCE].radiance[record].rays);
    }
    if (is_oversized(cache, radiance_ratio, near, count) &&
        (count == 1 || disagreement_exceeds(&glossy_sums, at->gather_deviation) ||
         disagreement_exceeds(&diffuse_sums, at->gather_deviation)))
        return (struct cache_used){0};
    if (lobe) *glossy = mean_value(&reflected, used.weight);
    if (E) *E = mean_value(&diffuse, used.weight);
    return used;
}

bool cache_has_record_near(const struct cache *cache, vec3 p, vec3 n, float radius) {
    return cache_tree_nearest(&cache->store[CACHE_IRRADIANCE].tree, p, n, radius) >= 0 ||
           cache_tree_nearest(&cache->store[CACHE_RADIANCE].tree, p, n, radius) >= 0;
}

float cache_irradiance_reflected(const struct cache *cache, uint32_t record,
                                 const struct cache_lookup *at, float a,
                                 const struct cache_surface *surface, float *noise) {
    const struct taylor t = irradiance_of(cache, record, at, a);
    const float Y = rgb_luminance(rgb_mul(surface->diffuse, value_alone(&t)));
    *noise = cache->store[CACHE_IRRADIANCE].irradiance[record].deviation * Y;
    return Y;
}

float cache_radiance_reflected(const struct cache *cache, uint32_t record,
                               const struct cache_lookup *at, float a,
                               const struct cache_surface *surface, float *noise) {
    const struct cache_lobe cosine = {
        .C = cache->cosine, .order = cache->cosine_order, .channels = 1};
    struct taylor t;
    rgb L = rgb_grey(0.0f);
    float factor = 0.0f;
    *noise = 0.0f;
    if (surface->lobe.order) {
        t = radiance_of(cache, record, at, a, surface->lobe, &factor);
        L = rgb_mul(surface->specular, value_alone(&t));
        *noise += factor * rgb_luminance(surface->specular);
    }
    if (!rgb_black(surface->diffuse)) {
        t = radiance_of(cache, record, at, a, cosine, &factor);
        L = rgb_fma(L, surface->diffuse, value_alone(&t));
        *noise += factor * rgb_luminance(surface->diffuse);
    }
    return rgb_luminance(L);
}
