// SPDX-License-Identifier: Apache-2.0
// Reading the caches: what one record says of a place, and the weighted mean of those that are near
// [K05 (2.2), (3.2), (3.3)]. Deviation: half of what the gradients add is taken from their mean.
#include <stdlib.h>
#include <string.h>

#include "cache/cache_records.h"
#include "rsh/rsh.h"

// The records to interpolate at a place; where none is, the nearest one.
static int find(const struct cache *cache, const struct cache_tree *tree,
                const struct cache_lookup *at, float a, struct cache_near near[CACHE_NEAR_MAX]) {
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

// What a record tells: its value, its gradients, and the way from it to the place. Also sums of
// such over records.
struct taylor {
    float value[3];
    vec3 way, grad[3];        // along the surface
    vec3 turn, turn_grad[3];  // of the normal
};

static float linear(const struct taylor *t, int c) {
    return v3_dot(t->way, t->grad[c]) + v3_dot(t->turn, t->turn_grad[c]);
}

// What one record says.
static rgb alone(const struct taylor *t) {
    return rgb_make(t->value[0] + linear(t, 0), t->value[1] + linear(t, 1),
                    t->value[2] + linear(t, 2));
}

// What a record says errs by half the second derivative times the square of the way; the mean of
// bare values errs by as much the other way. So each record's gradient leads half the way, and the
// mean gradient half the mean way: where the records lie around the place, second order cancels.
static void add_record(struct taylor *sum, const struct taylor *t, float weight) {
    for (int c = 0; c < 3; c++) {
        sum->value[c] += weight * (t->value[c] + 0.5f * linear(t, c));
        sum->grad[c] = v3_mad(sum->grad[c], weight, t->grad[c]);
        sum->turn_grad[c] = v3_mad(sum->turn_grad[c], weight, t->turn_grad[c]);
    }
    sum->way = v3_mad(sum->way, weight, t->way);
    sum->turn = v3_mad(sum->turn, weight, t->turn);
}

static rgb mean_of(const struct taylor *sum, float weight) {
    const float share = 1.0f / weight, half = 0.5f * share * share;
    float mean[3];
    for (int c = 0; c < 3; c++)
        mean[c] = at_least(share * sum->value[c] + half * linear(sum, c), 0.0f);
    return rgb_make(mean[0], mean[1], mean[2]);
}

// E of one record at a place. A facet that is turned by an angle t sees E cos t, and what the
// rotation gradient adds sin t.
static struct taylor irradiance_of(const struct cache *cache, uint32_t record,
                                   const struct cache_lookup *at, float a) {
    const struct cache_head *h = &cache->side[CACHE_IRRADIANCE].tree.head[record];
    const struct gather_irradiance *value = &cache->irradiance[record].value;
    const float share = minf(v3_dot(at->n, at->frame.n), 1.0f);
    struct taylor t = {{share * value->E.r, share * value->E.g, share * value->E.b},
                       .way = way_from(h, at->p, a),
                       .turn = v3_cross(h->n, at->frame.n)};
    if (cache->side[CACHE_IRRADIANCE].options.gradients == SATIN_GRADIENTS_NONE) return t;
    for (int c = 0; c < 3; c++) {
        t.grad[c] = value->grad_t[c];
        t.turn_grad[c] = value->grad_r[c];
    }
    return t;
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

struct cache_used cache_irradiance(const struct cache *cache, const struct cache_lookup *at,
                                   float a, rgb *E) {
    const struct cache_tree *tree = &cache->side[CACHE_IRRADIANCE].tree;
    const float whole = cache->side[CACHE_IRRADIANCE].options.a;
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = find(cache, tree, at, a, near);
    if (count == 0 || crowded(cache, CACHE_IRRADIANCE, near, count)) return used;
    struct taylor sum = {0};
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        const struct taylor t = irradiance_of(cache, record, at, a);
        add_record(&sum, &t, near[i].weight);
        use(&used, &tree->head[record], near[i].weight, whole,
            cache->irradiance[record].value.rays);
    }
    *E = mean_of(&sum, used.weight);
    return used;
}

// Whether two frames agree so well that no coefficient needs turning.
static bool same_frame(const struct frame *a, const struct frame *b) {
    return v3_dot(a->n, b->n) > 1.0f - 1e-6f && v3_dot(a->u, b->u) > 1.0f - 1e-6f;
}

// sum_k C_k (Lambda, d/dx, d/dy)_k of one record, per colour, and the noise of the first: lanes of
// sums as in the record.
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

// What a lobe, given in the place's frame, reflects of one record; *noise, if not NULL, gets that
// of its luminance.
static struct taylor radiance_of(const struct cache *cache, uint32_t index,
                                 const struct cache_lookup *at, float a, struct cache_lobe lobe,
                                 float *noise) {
    const struct cache_radiance_record *record = &cache->radiance[index];
    const struct frame *frame = &record->frame;
    float turned[3 * RSH_MAX_COEFFICIENTS], sum[CACHE_LANES];
    if (!same_frame(&at->frame, frame)) cache_turn(cache, &at->frame, frame, &lobe, turned);
    product(record, &lobe, sum);
    if (noise) *noise = fabsf(sum[3]);
    const rgb rest = cache_residual_read(&record->residual, &lobe);
    struct taylor t = {{sum[0] + rest.r, sum[1] + rest.g, sum[2] + rest.b},
                       .way = way_from(&cache->side[CACHE_RADIANCE].tree.head[index], at->p, a)};
    if (cache->side[CACHE_RADIANCE].options.gradients == SATIN_GRADIENTS_NONE) return t;
    for (int c = 0; c < 3; c++)
        t.grad[c] = v3_mad(v3_mul(frame->u, sum[4 + c]), sum[8 + c], frame->v);
    return t;
}

struct cache_used cache_radiance(const struct cache *cache, const struct cache_lookup *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E) {
    const struct cache_tree *tree = &cache->side[CACHE_RADIANCE].tree;
    const float whole = cache->side[CACHE_RADIANCE].options.a;
    struct cache_near near[CACHE_NEAR_MAX];
    struct cache_used used = {0};
    const int count = find(cache, tree, at, a, near);
    if (count == 0 || crowded(cache, CACHE_RADIANCE, near, count)) return used;
    const struct cache_lobe cosine = {
        .C = cache->cosine, .order = cache->cosine_order, .channels = 1};
    struct taylor shine = {0}, diffuse = {0};
    for (int i = 0; i < count; i++) {
        const uint32_t record = near[i].record;
        const float w = near[i].weight;
        struct taylor t;
        if (lobe) {
            t = radiance_of(cache, record, at, a, *lobe, NULL);
            add_record(&shine, &t, w);
        }
        if (E) {
            t = radiance_of(cache, record, at, a, cosine, NULL);
            add_record(&diffuse, &t, w);
        }
        use(&used, &tree->head[record], w, whole, cache->radiance[record].rays);
    }
    if (lobe) *glossy = mean_of(&shine, used.weight);
    if (E) *E = mean_of(&diffuse, used.weight);
    return used;
}

bool cache_stands(const struct cache *cache, vec3 p, vec3 n, float reach) {
    return cache_tree_nearest(&cache->side[CACHE_IRRADIANCE].tree, p, n, reach) >= 0 ||
           cache_tree_nearest(&cache->side[CACHE_RADIANCE].tree, p, n, reach) >= 0;
}

float cache_reflected(const struct cache *cache, enum cache_kind kind, uint32_t record,
                      const struct cache_lookup *at, float a, const struct cache_surface *surface,
                      float *noise) {
    struct taylor t;
    *noise = 0.0f;
    if (kind == CACHE_IRRADIANCE) {
        t = irradiance_of(cache, record, at, a);
        float Y = rgb_luminance(rgb_mul(surface->diffuse, alone(&t)));
        *noise = cache->irradiance[record].deviation * Y;
        return Y;
    }
    const struct cache_lobe cosine = {
        .C = cache->cosine, .order = cache->cosine_order, .channels = 1};
    rgb L = rgb_grey(0.0f);
    float part = 0.0f;
    if (surface->lobe.order) {
        t = radiance_of(cache, record, at, a, surface->lobe, &part);
        L = rgb_mul(surface->specular, alone(&t));
        *noise += part * rgb_luminance(surface->specular);
    }
    if (!rgb_black(surface->diffuse)) {
        t = radiance_of(cache, record, at, a, cosine, &part);
        L = rgb_fma(L, surface->diffuse, alone(&t));
        *noise += part * rgb_luminance(surface->diffuse);
    }
    return rgb_luminance(L);
}
