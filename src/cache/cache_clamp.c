// SPDX-License-Identifier: Apache-2.0
// How far a record may reach: the harmonic mean distance, limited by what its gradient can carry,
// by its neighbours' radii and by the projected pixel [K05 3.3, 6.5].
#include "cache/cache_records.h"

// Neighbours count as alike if their normals are closer than about 25 degrees.
static const float ALIKE = 0.9f;

// Records farther away than this part of R bear on it through those in between.
static const float NEIGHBOURS = 0.4f;

// The shape-scale bound on a radius where nothing was hit.
static float bounded(float R, const struct cache *cache) {
    return fminf(R, cache->g->scene->radius);
}

static float pixel_clamp(float R, float a, float pixel, float least, float most) {
    float lo = least * pixel / a, hi = most * pixel / a;
    if (R > hi) R = hi;
    return R < lo ? lo : R;
}

float cache_clamp_irradiance(const struct cache *cache, const struct cache_site *site, float a,
                             struct gather_irradiance *value) {
    const satin_options *o = cache->g->options;
    float R = bounded(value->R, cache);
    float E = rgb_luminance(value->E);
    vec3 grad = v3_mul(value->grad_t[0], 0.212671f);
    grad = v3_mad(grad, 0.715160f, value->grad_t[1]);
    grad = v3_mad(grad, 0.072169f, value->grad_t[2]);
    float slope = v3_len(grad);
    // E may not change by more than itself within R [K05 6.5.1].
    if (slope * R > E && E > 0.0f) R = E / slope;
    R = pixel_clamp(R, a, site->pixel, o->irradiance_min_pixels, INFINITY);
    // Where the pixel holds the radius up, the gradient gives way: never extrapolate E below 0.
    const float Ec[3] = {value->E.r, value->E.g, value->E.b};
    for (int c = 0; c < 3; c++) {
        float change = v3_len(value->grad_t[c]) * a * o->irradiance_widen * R;
        if (change > Ec[c]) value->grad_t[c] = v3_mul(value->grad_t[c], Ec[c] / change);
    }
    return R;
}

// Squared lengths of a colour's vector and of its gradient.
static void lengths2(const struct gather_radiance *value, int n2, int channel, float *size2,
                     float *slope2) {
    const float *lambda = value->lambda + channel * n2;
    const float *dx = value->dx + channel * n2, *dy = value->dy + channel * n2;
    *size2 = *slope2 = 0.0f;
    for (int k = 0; k < n2; k++) {
        *size2 += lambda[k] * lambda[k];
        *slope2 += dx[k] * dx[k] + dy[k] * dy[k];
    }
}

float cache_clamp_radiance(const struct cache *cache, const struct cache_site *site, float a,
                           struct gather_radiance *value) {
    const satin_options *o = cache->g->options;
    const int n2 = cache->order * cache->order;
    float size2[3], slope2[3];
    for (int c = 0; c < 3; c++) lengths2(value, n2, c, &size2[c], &slope2[c]);
    float size = sqrtf(size2[0] + size2[1] + size2[2]);
    float slope = sqrtf(slope2[0] + slope2[1] + slope2[2]);
    // As for E: the vector may not change by more than its length within R. Measured where a wall
    // reflects a box near to it: half of the records serve for the same error.
    float R = bounded(value->R, cache);
    if (slope * R > size && size > 0.0f) R = size / slope;
    R = pixel_clamp(R, a, site->pixel, o->radiance_min_pixels, o->radiance_max_pixels);
    // Where the pixel holds the radius up, the gradient of each colour gives way.
    for (int c = 0; c < 3; c++) {
        float change = sqrtf(slope2[c]) * a * o->radiance_widen * R, length = sqrtf(size2[c]);
        if (!(change > length)) continue;
        for (int k = c * n2; k < (c + 1) * n2; k++) {
            value->dx[k] *= length / change;
            value->dy[k] *= length / change;
        }
    }
    return R;
}

struct neighbours {
    struct cache_tree *tree;
    vec3 p, n;
    float R;
    bool lower;  // second walk: lower the neighbours
};

static void clamp_one(void *ctx, uint32_t record) {
    struct neighbours *s = ctx;
    struct cache_head *h = &s->tree->head[record];
    if (v3_dot(h->n, s->n) < ALIKE) return;
    float d = sqrtf(v3_dist2(h->p, s->p));
    if (s->lower)
        h->R = fminf(h->R, s->R + d);
    else
        s->R = fminf(s->R, h->R + d);
}

float cache_clamp_neighbours(struct cache_tree *tree, vec3 p, vec3 n, float R) {
    struct neighbours s = {tree, p, n, R, false};
    cache_tree_visit(tree, p, NEIGHBOURS * R, clamp_one, &s);
    s.lower = true;
    cache_tree_visit(tree, p, NEIGHBOURS * s.R, clamp_one, &s);
    return s.R;
}
