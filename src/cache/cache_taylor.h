// SPDX-License-Identifier: Apache-2.0
// The light of records at points near them, by their gradients, and the weighted mean over several
// records [K05 (2.2), (3.2), (3.3)]. For the folders that read and make records.
#ifndef CACHE_TAYLOR_H
#define CACHE_TAYLOR_H

#include "cache/cache_records.h"

// Facets whose cosine with the surface is larger have less than .01 % of E behind them.
#define CACHE_FACET_COSINE 0.9998f

// A point at which interpolated light is needed.
struct cache_lookup {
    vec3 p, n;               // position, and normal without bump and normal maps
    struct frame frame;      // of the BRDF; its n is the normal with bump and normal maps
    float gather_deviation;  // relative standard deviation of gathering at the point instead of
                             // reading records
};

// The offset from a record to p, limited to the length for which the record's gradient is valid.
static inline vec3 cache_taylor_offset(const struct cache_head *h, vec3 p, float a) {
    vec3 d = v3_sub(p, h->p);
    float length = v3_len(d), most = a * h->R;
    return length > most ? v3_mul(d, most / length) : d;
}

// A record's value and gradients, and the offset and rotation from it to the point. Also used for
// weighted sums of these.
struct cache_taylor {
    float value[3];
    vec3 offset, grad[3];             // on the surface
    vec3 rotation, rotation_grad[3];  // of the normal
};

// The change of a channel from the record to the point.
static inline float cache_taylor_change(const struct cache_taylor *t, int c) {
    return v3_dot(t->offset, t->grad[c]) + v3_dot(t->rotation, t->rotation_grad[c]);
}

// The value at the point from this record alone.
static inline rgb cache_taylor_value(const struct cache_taylor *t) {
    return rgb_make(t->value[0] + cache_taylor_change(t, 0),
                    t->value[1] + cache_taylor_change(t, 1),
                    t->value[2] + cache_taylor_change(t, 2));
}

// A value that is extrapolated by its gradient has an error of half the second derivative times the
// squared distance; the mean of values without gradients has the opposite error. So each record's
// gradient is applied to half of its offset, and the mean gradient to half of the mean offset: if
// records surround the point, errors of second order cancel.
static inline void cache_taylor_add(struct cache_taylor *sum, const struct cache_taylor *t,
                                    float weight) {
    for (int c = 0; c < 3; c++) {
        sum->value[c] += weight * (t->value[c] + 0.5f * cache_taylor_change(t, c));
        sum->grad[c] = v3_mad(sum->grad[c], weight, t->grad[c]);
        sum->rotation_grad[c] = v3_mad(sum->rotation_grad[c], weight, t->rotation_grad[c]);
    }
    sum->offset = v3_mad(sum->offset, weight, t->offset);
    sum->rotation = v3_mad(sum->rotation, weight, t->rotation);
}

// The mean of records that were added with weights of this sum; at least 0.
static inline rgb cache_taylor_mean(const struct cache_taylor *sum, float weight) {
    const float inverse = 1.0f / weight, half = 0.5f * inverse * inverse;
    float mean[3];
    for (int c = 0; c < 3; c++)
        mean[c] = at_least(inverse * sum->value[c] + half * cache_taylor_change(sum, c), 0.0f);
    return rgb_make(mean[0], mean[1], mean[2]);
}

// What the rotation of E by its gradient leaves out on a facet: it counts the light between the
// surface and the plane of the facet, which is behind the facet, as negative. Under radiance that
// is linear in the direction along the surface, with this E and gradient, the light there is
// E (1 - cos t) / 2 - t / pi dE for an angle t, where dE is the change by the gradient.
static inline float cache_taylor_behind(float E, float cosine, float dE) {
    return at_least(0.5f * (1.0f - cosine) * E - acosf(at_least(cosine, -1.0f)) / PI_F * dE, 0.0f);
}

// E on a facet that is rotated from the normal n to `facing`, where E and its rotation gradient are
// those of the normal `from`.
static inline struct cache_taylor cache_taylor_rotate(const struct cache_irradiance_value *value,
                                                      vec3 from, vec3 n, vec3 facing) {
    const float cosine = minf(v3_dot(n, facing), 1.0f), E[] = {value->E.r, value->E.g, value->E.b};
    const vec3 rotation = v3_cross(n, facing);
    struct cache_taylor t = {.rotation = v3_cross(from, facing)};
    for (int c = 0; c < 3; c++) {
        t.value[c] = cosine * E[c];
        if (cosine < CACHE_FACET_COSINE)
            t.value[c] += cache_taylor_behind(E[c], cosine, v3_dot(rotation, value->grad_r[c]));
        t.rotation_grad[c] = value->grad_r[c];
    }
    return t;
}

// E of one record at a point, on a facet that bumps rotate.
static inline struct cache_taylor cache_taylor_irradiance(const struct cache *cache,
                                                          uint32_t record,
                                                          const struct cache_lookup *at, float a) {
    const struct cache_head *h = &cache->store[CACHE_IRRADIANCE].tree.head[record];
    const struct cache_irradiance_value *value =
        &cache->store[CACHE_IRRADIANCE].irradiance[record].value;
    struct cache_taylor t = cache_taylor_rotate(value, h->n, at->n, at->frame.n);
    t.offset = cache_taylor_offset(h, at->p, a);
    const bool gradients = cache->store[CACHE_IRRADIANCE].options.gradients != SATIN_GRADIENTS_NONE;
    for (int c = 0; c < 3; c++) {
        t.grad[c] = gradients ? value->grad_t[c] : v3(0, 0, 0);
        if (!gradients) t.rotation_grad[c] = v3(0, 0, 0);
    }
    return t;
}

#endif
