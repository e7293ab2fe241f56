// SPDX-License-Identifier: Apache-2.0
// The extent of a record: from the distances of the hits of its rays, or from the Hessian of its
// irradiance; then limited by its gradient and by the projected pixel [K05 3.3, 6.5.1].
#include "fill/fill_record.h"

// R from the Hessian is such that the second-order term of E at a distance of a R is a^2 times this
// fraction of E.
static const float SECOND_ORDER = 0.5f;

// An elliptic record is at most LONGEST times longer than wide, and its R is at most FARTHEST times
// the harmonic mean distance.
static const float LONGEST = 3.0f, FARTHEST = 2.0f;

static float by_distance(satin_radius kind, const struct gather_surroundings *around) {
    if (kind == SATIN_RADIUS_LEAST) return around->least;
    if (kind == SATIN_RADIUS_TABELLION) return around->least_upright;
    return around->harmonic;
}

// Limits a radius by that of the scene, where nothing was hit, and by the user's limit.
static float limit_radius(float R, const struct cache *cache, const struct cache_options *o) {
    R = fminf(R, cache->scene->radius);
    return o->max_radius > 0.0f ? fminf(R, o->max_radius) : R;
}

static struct fill_extent circle(float R) { return (struct fill_extent){R, R, {0, 0, 0}, 1.0f}; }

// Radii along the eigenvectors of the Hessian, whose eigenvalues are lambda:
// sqrt(2 SECOND_ORDER E / |lambda|) [Schwarzhaupt et al. 2012].
static struct fill_extent by_hessian(const struct gather_surroundings *around,
                                     const struct frame *frame, float E) {
    const float xx = around->hessian[0], xy = around->hessian[1], yy = around->hessian[2];
    float mean = 0.5f * (xx + yy), half = sqrtf(0.25f * (xx - yy) * (xx - yy) + xy * xy);
    float most = fabsf(mean) + half, least = fabsf(fabsf(mean) - half);
    if (!(most > 0.0f) || !(E > 0.0f)) return circle(around->harmonic);
    // The angle of the eigenvector with the eigenvalue of larger magnitude.
    float angle = 0.5f * atan2f(2.0f * xy, xx - yy);
    if (mean < 0.0f) angle += 0.5f * PI_F;
    float narrow = sqrtf(2.0f * SECOND_ORDER * E / most);
    float wide = fminf(narrow * sqrtf(most / fmaxf(least, 1e-12f * most)), LONGEST * narrow);
    const float limit = FARTHEST * around->harmonic;
    vec3 axis = v3_add(v3_mul(frame->u, cosf(angle)), v3_mul(frame->v, sinf(angle)));
    return (struct fill_extent){fminf(wide, limit), fminf(narrow, limit), axis, 1.0f};
}

// If the least radius of the options exceeds the largest one, the largest is used.
float fill_least_radius(const struct fill *fill, enum cache_kind kind, float pixel) {
    const struct cache_options *o = &fill->cache->store[kind].options;
    const float least = fill->side[kind].radius_fraction * o->min_pixels;
    const float R = fminf(least, o->max_pixels) * pixel / o->a;
    return o->max_radius > 0.0f ? fminf(R, o->max_radius) : R;
}

// Clamps the radii of both axes to [lo, hi]. If that makes a record larger than it should be, its
// gradient would extrapolate too far and is scaled by `radius_ratio`.
static void clamp_radii(struct fill_extent *x, float lo, float hi) {
    const float wanted = x->R;
    x->R = fmaxf(fminf(x->R, hi), lo);
    x->across = fmaxf(fminf(x->across, x->R), lo);
    x->radius_ratio = fminf(wanted / x->R, 1.0f);
}

static void limit_extent(struct fill_extent *x, float R) {
    x->R = fminf(x->R, R);
    x->across = fminf(x->across, x->R);
}

static vec3 luminance_gradient(const struct cache_irradiance_value *value) {
    vec3 grad = v3_mul(value->grad_t[0], LUMINANCE_R);
    grad = v3_mad(grad, LUMINANCE_G, value->grad_t[1]);
    return v3_mad(grad, LUMINANCE_B, value->grad_t[2]);
}

struct fill_extent fill_extent_irradiance(const struct fill *fill, const struct fill_site *site,
                                          const struct gather_surroundings *around,
                                          struct cache_irradiance_value *value) {
    const struct cache *cache = fill->cache;
    const struct cache_options *o = &cache->store[CACHE_IRRADIANCE].options;
    const float E = rgb_luminance(value->E);
    struct fill_extent x = o->radius == SATIN_RADIUS_HESSIAN
                               ? by_hessian(around, &site->frame, E)
                               : circle(by_distance(o->radius, around));
    limit_extent(&x, limit_radius(x.R, cache, o));
    // E may not change by more than itself within R [K05 6.5.1].
    const float slope = v3_len(luminance_gradient(value));
    if (o->gradient_clamp && slope * x.R > E && E > 0.0f) limit_extent(&x, E / slope);
    clamp_radii(&x, fill_least_radius(fill, CACHE_IRRADIANCE, site->pixel),
                o->max_pixels * site->pixel / o->a);
    // The gradient must not extrapolate E below 0.
    const float Ec[3] = {value->E.r, value->E.g, value->E.b};
    for (int c = 0; c < 3; c++) {
        float change = x.radius_ratio * v3_len(value->grad_t[c]) * o->a * o->widen * x.R;
        float factor = change > Ec[c] ? x.radius_ratio * Ec[c] / change : x.radius_ratio;
        value->grad_t[c] = v3_mul(value->grad_t[c], factor);
    }
    return x;
}

// The squared lengths of the coefficient vector of a channel and of its gradient.
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

struct fill_extent fill_extent_radiance(const struct fill *fill, const struct fill_site *site,
                                        const struct gather_surroundings *around, float most,
                                        struct gather_radiance *value) {
    const struct cache *cache = fill->cache;
    const struct cache_store *store = &cache->store[CACHE_RADIANCE];
    const struct cache_options *o = &store->options;
    const int n2 = store->order * store->order;
    float size2[3], slope2[3];
    for (int c = 0; c < 3; c++) lengths2(value, n2, c, &size2[c], &slope2[c]);
    const float size = sqrtf(size2[0] + size2[1] + size2[2]);
    const float slope = sqrtf(slope2[0] + slope2[1] + slope2[2]);
    struct fill_extent x =
        circle(fminf(limit_radius(by_distance(o->radius, around), cache, o), most));
    // As for E, the vector may not change by more than its length within R. Measured where a wall
    // reflects a box near it: with this limit, half of the records are enough for the same error.
    if (o->gradient_clamp && slope * x.R > size && size > 0.0f) limit_extent(&x, size / slope);
    clamp_radii(&x, fill_least_radius(fill, CACHE_RADIANCE, site->pixel),
                o->max_pixels * site->pixel / o->a);
    for (int c = 0; c < 3; c++) {
        float change = x.radius_ratio * sqrtf(slope2[c]) * o->a * o->widen * x.R;
        float length = sqrtf(size2[c]),
              factor = change > length ? x.radius_ratio * length / change : x.radius_ratio;
        for (int k = c * n2; factor < 1.0f && k < (c + 1) * n2; k++) {
            value->dx[k] *= factor;
            value->dy[k] *= factor;
        }
    }
    return x;
}
