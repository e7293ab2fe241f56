// SPDX-License-Identifier: Apache-2.0
// What the rays of a hemisphere show of the surroundings of a record: distances, from which its
// radius R follows; the noise of E and of its gradient; and the Hessian of E. This is the occlusion
// Hessian of Schwarzhaupt et al. [2012], formulated for the strata of the stratified hemisphere:
// the boundary between two strata is at the nearer of their hits, where an occluder's edge would
// be, so E is a sum of polygons under the cosine law. The second derivative of the edge of such a
// polygon is a constant of the boundary over the squared distance.
#include "gather/gather_gradients.h"

// The least cosine, at both ends, of rays that show near geometry [Tabellion and Lamorlette 2004].
static const float RAY_GRAZING = 0.2f;

static void distances(const struct gather_hemisphere *h, struct gather_surroundings *out) {
    double sum = 0.0;
    for (size_t i = 0; i < h->stratified; i++) {
        const struct gather_ray *ray = &h->ray[i];
        float r = ray->first.r;
        sum += 1.0 / (double)r;  // a miss adds 0
        out->least = fminf(out->least, r);
        if (h->z[i] > RAY_GRAZING || fabsf(v3_dot(ray->ray.d, ray->first.ng)) > RAY_GRAZING)
            out->least_upright = fminf(out->least_upright, r);
    }
    if (sum > 0.0) out->harmonic = (float)((double)h->stratified / sum);
}

// The least distances along the tangent plane, by azimuth, of hits below 45 degrees of elevation:
// steeper rays hit surfaces above the record.
static void sectors(const struct gather_hemisphere *h, struct gather_surroundings *out) {
    const struct gather_layout *l = h->layout;
    for (int k = 0; k < l->N; k++) {
        float near = INFINITY;
        for (int j = 0; j < l->M; j++) {
            size_t i = (size_t)(j * l->N + k);
            float sine = sqrtf(h->x[i] * h->x[i] + h->y[i] * h->y[i]);
            if (h->z[i] < sine) near = fminf(near, h->ray[i].first.r * sine);
        }
        int first = k * CACHE_SECTORS / l->N, last = (k + 1) * CACHE_SECTORS / l->N;
        for (int s = first; s <= last; s++) {
            float *sector = &out->sector[s % CACHE_SECTORS];
            *sector = fminf(*sector, near);
        }
    }
}

// The standard deviation of E over E, from the spread of interleaved subsets of rays. Deviation:
// [K05 6.4] compares every second ray with all of them, which is sometimes 0 by chance.
static float deviation(const struct gather_hemisphere *h) {
    const struct gather_layout *l = h->layout;
    enum { SUBSETS = 8 };
    double sum[SUBSETS] = {0}, weight[SUBSETS] = {0}, all = 0.0, total = 0.0, square = 0.0;
    for (int j = 0; j < l->M; j++)
        for (int k = 0; k < l->N; k++) {
            size_t i = (size_t)(j * l->N + k);
            double w = l->order ? (double)h->z[i] : 1.0;
            sum[(3 * j + k) % SUBSETS] += w * (double)rgb_luminance(h->L[i]);
            weight[(3 * j + k) % SUBSETS] += w;
        }
    for (size_t i = h->stratified; i < h->count; i++) {
        double w = l->order ? (double)h->z[i] : 1.0;
        sum[i % SUBSETS] += w * (double)rgb_luminance(h->L[i]);
    }
    for (int i = 0; i < SUBSETS; i++) {
        all += sum[i];
        total += weight[i];
    }
    if (all == 0.0) return 0.0f;
    int subsets = 0;
    for (int i = 0; i < SUBSETS; i++) {
        if (!(weight[i] > 0.0)) continue;
        double d = sum[i] / weight[i] * total / all - 1.0;
        square += d * d;
        subsets++;
    }
    return subsets > 1 ? (float)sqrt(square / (subsets * (subsets - 1))) : 0.0f;
}

// The standard deviation of the gradient of E over E.
static float gradient_deviation(const struct gather_hemisphere *h, satin_gradients kind) {
    float E = 0.0f, variance = 0.0f;
    for (size_t i = 0; i < h->count; i++) E += rgb_luminance(h->L[i]);
    E *= PI_F / (float)h->stratified;
    if (!(E > 0.0f) || kind == SATIN_GRADIENTS_NONE) return 0.0f;
    if (kind == SATIN_GRADIENTS_SOLID_ANGLE || kind == SATIN_GRADIENTS_DIFFERENCES)
        variance = gather_solid_angle_variance(h, 0);
    else
        variance = gather_stratified_variance(h) + gather_solid_angle_variance(h, h->stratified);
    return sqrtf(variance) / E;
}

// Adds the constant of a boundary, rotated from azimuth 0 to that of (cosine, sine), times
// `weight`.
static void add_rotated(const float constant[3], float cosine, float sine, float weight,
                        float hessian[3]) {
    float cc = cosine * cosine, ss = sine * sine, cs = cosine * sine;
    hessian[0] += weight * (cc * constant[0] - 2.0f * cs * constant[1] + ss * constant[2]);
    hessian[1] += weight * (cs * (constant[0] - constant[2]) + (cc - ss) * constant[1]);
    hessian[2] += weight * (ss * constant[0] + 2.0f * cs * constant[1] + cc * constant[2]);
}

// The change of luminance across the boundary between the strata of two rays, over the squared
// distance of the nearer side. `to` -1: beyond it is nothing.
static float step_over(const struct gather_hemisphere *h, int from, int to) {
    const float here = h->ray[from].first.r;
    const float r = to < 0 ? here : fminf(here, h->ray[to].first.r);
    if (!(isfinite(r) && r > 0.0f)) return 0.0f;
    return (rgb_luminance(h->L[from]) - (to < 0 ? 0.0f : rgb_luminance(h->L[to]))) / (r * r);
}

// Adds the contribution of the stratified rays to the Hessian.
static void add_boundaries(const struct gather_hemisphere *h, float hessian[3]) {
    const struct gather_layout *l = h->layout;
    const int N = l->N;
    for (int j = 0; j < l->M; j++)
        for (int k = 0; k < N; k++) {
            const int here = j * N + k, before = j * N + (k ? k - 1 : N - 1);
            const int below = j + 1 < l->M ? here + N : -1;
            add_rotated(l->hessian_u[j], l->cos_k[k], l->sin_k[k], step_over(h, here, below),
                        hessian);
            add_rotated(l->hessian_v[j], l->cos_w[k], l->sin_w[k], step_over(h, before, here),
                        hessian);
        }
}

// Adds the contribution of a guided ray, which represents a patch around its hit q: the second
// derivative of f = cos(theta) Omega, computed from that of its logarithm. Symbols as in
// gather_solid_angle.c, v = q - p.
static void add_point(const struct gather_hemisphere *h, size_t i, float weight, float out[3]) {
    const struct gather_ray *ray = &h->ray[i];
    const float r = ray->first.r;
    const vec3 w = v3(h->x[i], h->y[i], h->z[i]);
    const vec3 n = frame_to_local(&h->frame, ray->first.ng);
    const float c = -v3_dot(n, w);
    if (!(isfinite(r) && r > 0.0f && fabsf(c) > RAY_GRAZING)) return;
    const float value = weight * rgb_luminance(h->L[i]) / (r * r);
    const float gx = n.x / c + 4.0f * w.x, gy = n.y / c + 4.0f * w.y;
    out[0] += value * (gx * gx - n.x * n.x / (c * c) + 8.0f * w.x * w.x - 4.0f);
    out[1] += value * (gx * gy - n.x * n.y / (c * c) + 8.0f * w.x * w.y);
    out[2] += value * (gy * gy - n.y * n.y / (c * c) + 8.0f * w.y * w.y - 4.0f);
}

void gather_surroundings_make(const struct gather_hemisphere *h, satin_gradients gradients,
                              bool hessian, struct gather_surroundings *out) {
    *out = (struct gather_surroundings){.harmonic = INFINITY, .least = INFINITY};
    out->least_upright = INFINITY;
    for (int s = 0; s < CACHE_SECTORS; s++) out->sector[s] = INFINITY;
    distances(h, out);
    sectors(h, out);
    out->deviation = deviation(h);
    if (h->layout->order) return;
    out->gradient_deviation = gradient_deviation(h, gradients);
    if (!hessian) return;
    add_boundaries(h, out->hessian);
    for (size_t i = h->stratified; i < h->count; i++)
        add_point(h, i, PI_F / (float)h->stratified, out->hessian);
}
