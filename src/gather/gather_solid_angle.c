// SPDX-License-Identifier: Apache-2.0
// Solid-angle-based gradients [K05 4.2]: each ray represents a small area around its hit q, which
// keeps its position and radiance when the centre p moves. Its direction changes, and its solid
// angle Omega by the distance r and by the cosine c between its normal n and the ray. Changes of
// occlusion are ignored: where they matter, stratified gradients are correct and these are not.
// Symbols: w direction, L radiance.
#include <string.h>

#include "gather/gather_gradients.h"
#include "rsh/rsh.h"

// Areas that the ray hits at less than this cosine would add most of the variance and little of the
// gradient.
static const float AREA_GRAZING = 0.01f;

// Half the step of finite differences, in units of the distance r of each ray: harmonics of order
// 14 are linear over it to .1 %, and float differences keep four digits.
static const float DIFFERENCE_STEP = 0.005f;

enum { RAY_BLOCK = 16 };  // rays whose derivatives are summed at once

// The hit of a ray, as its derivatives need it.
struct ray_hit {
    vec3 w, n;   // local
    float c, r;  // c = -n . w, whose sign is that of the side of n
};

// False if the change of the light of ray i is unknown.
static bool ray_hit_of(const struct gather_hemisphere *h, size_t i, struct ray_hit *out) {
    const struct gather_first *first = &h->ray[i].first;
    if (!(first->r > 0.0f) || !isfinite(first->r)) return false;
    out->w = v3(h->x[i], h->y[i], h->z[i]);
    out->n = frame_to_local(&h->frame, first->ng);
    out->c = -v3_dot(out->n, out->w);
    out->r = first->r;
    return fabsf(out->c) > AREA_GRAZING;
}

// Moves the centre by `step` r along `axis`: returns the new length of the ray over r, and sets *w
// to its direction and *omega to its solid angle over the previous one.
static float displace(const struct ray_hit *at, vec3 axis, float step, vec3 *w, float *omega) {
    vec3 v = v3_mad(at->w, -step, axis);
    float length = v3_len(v), scale = 1.0f / length;
    *w = v3_mul(v, scale);
    *omega = -v3_dot(at->n, v) / at->c * scale * scale * scale;
    return length;
}

static float cosine_difference(const struct ray_hit *at, vec3 axis) {
    float change = 0.0f;
    for (int side = -1; side <= 1; side += 2) {
        vec3 w;
        float omega, length = displace(at, axis, (float)side * DIFFERENCE_STEP, &w, &omega);
        change += (float)side * omega / length;  // of cos(theta) Omega
    }
    return change / (2.0f * DIFFERENCE_STEP * at->r);
}

// The change of cos(theta) Omega of a ray, over it.
static vec3 cosine_change(const struct ray_hit *at) {
    const vec3 change = v3_mul(v3_mad(v3_mul(at->n, 1.0f / at->c), 4.0f, at->w), 1.0f / at->r);
    return v3(change.x, change.y, 0.0f);
}

// Rays are distributed in proportion to the cosine, so cos(theta) Omega of each is pi / count [K05
// 4.2.3].
void gather_solid_angle_irradiance(const struct gather_hemisphere *h, bool differences,
                                   size_t first, vec3 grad[3]) {
    const float weight = PI_F / (float)h->stratified;
    const size_t count = h->count;
    for (size_t i = first; i < count; i++) {
        struct ray_hit at;
        if (!ray_hit_of(h, i, &at)) continue;
        vec3 change;
        if (differences) {
            change =
                v3(cosine_difference(&at, v3(1, 0, 0)), cosine_difference(&at, v3(0, 1, 0)), 0.0f);
        } else {
            change = cosine_change(&at);
        }
        const rgb L = rgb_scale(h->L[i], weight);
        grad[0] = v3_mad(grad[0], L.r, change);
        grad[1] = v3_mad(grad[1], L.g, change);
        grad[2] = v3_mad(grad[2], L.b, change);
    }
}

// As if each ray was there by chance, independently of the others.
float gather_solid_angle_variance(const struct gather_hemisphere *h, size_t first) {
    const float weight = PI_F / (float)h->stratified;
    float both = 0.0f;
    for (size_t i = first; i < h->count; i++) {
        struct ray_hit at;
        if (ray_hit_of(h, i, &at))
            both += sqrf(weight * rgb_luminance(h->L[i])) * v3_len2(cosine_change(&at));
    }
    return 0.5f * both;
}

// The derivatives of Omega H, over Omega, by x and y for one ray [K05 (4.3)-(4.8)].
static void derive(const struct gather_layout *l, const struct ray_hit *at, float *by_x,
                   float *by_y) {
    const int n2 = l->order * l->order;
    float H[RSH_MAX_COEFFICIENTS], dtheta[RSH_MAX_COEFFICIENTS], dphi[RSH_MAX_COEFFICIENTS];
    const float w[3] = {at->w.x, at->w.y, at->w.z};
    rsh_eval_derivatives(brdf_rsh_basis(l->basis), l->order, w, H, dtheta, dphi);
    const float sine = fmaxf(sqrtf(w[0] * w[0] + w[1] * w[1]), 1e-6f), per_r = 1.0f / at->r;
    const float cos_phi = w[0] / sine, sin_phi = w[1] / sine;
    const float omega_x = (at->n.x / at->c + 3.0f * w[0]) * per_r;
    const float omega_y = (at->n.y / at->c + 3.0f * w[1]) * per_r;
    const float theta_x = -w[2] * cos_phi * per_r, theta_y = -w[2] * sin_phi * per_r;
    const float phi_x = sin_phi / sine * per_r, phi_y = -cos_phi / sine * per_r;
    for (int k = 0; k < n2; k++) {
        by_x[k] = omega_x * H[k] + theta_x * dtheta[k] + phi_x * dphi[k];
        by_y[k] = omega_y * H[k] + theta_y * dtheta[k] + phi_y * dphi[k];
    }
}

static void differentiate(const struct gather_hemisphere *h, size_t first, float *dx, float *dy) {
    const size_t count = h->count;
    const size_t n2 = (size_t)(h->layout->order * h->layout->order);
    float by_x[RAY_BLOCK * RSH_MAX_COEFFICIENTS], by_y[RAY_BLOCK * RSH_MAX_COEFFICIENTS];
    for (size_t i = first; i < count; i += RAY_BLOCK) {
        size_t n = count - i < RAY_BLOCK ? count - i : RAY_BLOCK;
        memset(by_x, 0, sizeof *by_x * n * n2);
        memset(by_y, 0, sizeof *by_y * n * n2);
        for (size_t k = 0; k < n; k++) {
            struct ray_hit at;
            if (ray_hit_of(h, i + k, &at)) derive(h->layout, &at, by_x + k * n2, by_y + k * n2);
        }
        rsh_accumulate(n, n2, by_x, h->r + i, h->g + i, h->b + i, dx);
        rsh_accumulate(n, n2, by_y, h->r + i, h->g + i, h->b + i, dy);
    }
}

// Adds one side of the difference quotient along an axis: a projection of displaced rays.
// Deviation: the step is proportional to r, so that near hits are as accurate as distant ones,
// while [K05 4.2.1] has a fixed step.
static void add_difference(const struct gather_hemisphere *h, size_t first, vec3 axis, float side,
                           float *out) {
    const struct gather_layout *l = h->layout;
    const size_t count = h->count;
    float *x = h->work, *y = x + count, *z = y + count, *r = z + count, *g = r + count,
          *b = g + count;
    for (size_t i = first; i < count; i++) {
        struct ray_hit at;
        vec3 w = v3(0.0f, 0.0f, 1.0f);
        float omega = 0.0f, value = 0.0f;
        if (ray_hit_of(h, i, &at)) {
            displace(&at, axis, side * DIFFERENCE_STEP, &w, &omega);
            value = side * omega / (2.0f * DIFFERENCE_STEP * at.r);
        }
        x[i] = w.x, y[i] = w.y, z[i] = w.z;
        r[i] = h->r[i] * value, g[i] = h->g[i] * value, b[i] = h->b[i] * value;
    }
    const rsh_samples samples = {count - first, x + first, y + first, z + first,
                                 r + first,     g + first, b + first};
    rsh_project(brdf_rsh_basis(l->basis), l->order, &samples, out);
}

void gather_solid_angle_radiance(const struct gather_hemisphere *h, bool differences, size_t first,
                                 float *dx, float *dy) {
    if (!differences) {
        differentiate(h, first, dx, dy);
        return;
    }
    for (int side = -1; side <= 1; side += 2) {
        add_difference(h, first, v3(1.0f, 0.0f, 0.0f), (float)side, dx);
        add_difference(h, first, v3(0.0f, 1.0f, 0.0f), (float)side, dy);
    }
}
