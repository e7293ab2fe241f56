// SPDX-License-Identifier: Apache-2.0
// Limits the radius R of a radiance record to where its gradient predicts the light that its
// surface reflects to the eye. The lobe of a glossy surface covers a small part of what surrounds
// it, which may change over a small fraction of the harmonic mean distance: the wall beside it, or
// the edge between two walls. The light that points around the record reflect is estimated from the
// record's own rays: these have hit points of surfaces, which lie from a displaced point in other
// directions and under other solid angles. What is hidden from the record remains hidden. The mean
// of points around it, minus the light at the record, is the Laplacian of the reflected light.
#include "fill/fill_record.h"

// The Laplacian of the reflected light times (a R)^2 is at most a^2 times this fraction of the
// light.
static const float LAPLACIAN_MOST = 0.2f;

// R is reduced in at most SHRINK_STEPS steps, each by a factor of at least SHRINK_LEAST, since the
// differences over the steps before were larger.
enum { SHRINK_STEPS = 3 };
static const float SHRINK_LEAST = 0.5f;

// Rays whose solid angle at a displaced point is this many times as large, or which have hit a
// surface that faces away from that point, are left as they are.
static const float JACOBIAN_MOST = 4.0f;

// Stratified rays of which the lobe reflects less than this fraction of its maximum are left out.
static const float REFLECTED_LEAST = 0.001f;

// The number of displaced points, which are on a circle, and of subsets of rays, whose variance is
// the noise.
enum { POINTS = 3, RAY_SUBSETS = 8 };

// The lobe of a record for one direction to the eye.
struct lobe_at_record {
    const struct gather_hemisphere *hemisphere;
    const struct brdf *brdf;
    vec3 wo;
};

// The luminance that the lobe reflects of unit radiance from wi, times the cosine.
static float lobe_reflects(const struct lobe_at_record *l, vec3 wi) {
    if (!(wi.z > 0.0f)) return 0.0f;
    return wi.z * rgb_luminance(brdf_eval(l->brdf, l->wo, wi, BRDF_GLOSSY));
}

static vec3 ray_direction(const struct gather_hemisphere *h, size_t i) {
    return v3(h->x[i], h->y[i], h->z[i]);
}

// The sum over the displaced points of what they reflect of a ray, minus POINTS times `here`, which
// is what the record reflects of it.
static float change_around(const struct lobe_at_record *l, size_t i, float step, float here) {
    static const float around[POINTS][2] = {
        {1.0f, 0.0f}, {-0.5f, 0.8660254f}, {-0.5f, -0.8660254f}};
    const struct gather_hemisphere *h = l->hemisphere;
    const struct gather_first *hit = &h->ray[i].first;
    const vec3 wi = ray_direction(h, i), n = frame_to_local(&h->frame, hit->ng);
    const float cosine = v3_dot(n, wi);
    float sum = 0.0f;
    for (int k = 0; k < POINTS; k++) {
        const vec3 offset = v3(step * around[k][0], step * around[k][1], 0.0f);
        const vec3 q = v3_sub(v3_mul(wi, hit->r), offset);
        const float r2 = v3_len2(q);
        if (!(r2 > 0.0f)) return 0.0f;
        const vec3 w = v3_mul(q, 1.0f / sqrtf(r2));
        float jacobian = hit->r * hit->r / r2;
        if (cosine != 0.0f) jacobian *= v3_dot(n, w) / cosine;
        if (!(jacobian > 0.0f && jacobian < JACOBIAN_MOST)) return 0.0f;
        sum += jacobian * lobe_reflects(l, w);
    }
    return sum - POINTS * here;
}

// The light that is reflected, without its factor, and what every ray adds to it.
struct reflection {
    double light, lobe;  // sums over the rays: light, and the lobe alone
    float most;          // the largest value of the lobe
};

static struct reflection find_reflection(const struct lobe_at_record *l, float *here) {
    const struct gather_hemisphere *h = l->hemisphere;
    struct reflection sum = {0};
    for (size_t i = 0; i < h->all; i++) {
        here[i] = lobe_reflects(l, ray_direction(h, i));
        sum.most = fmaxf(sum.most, here[i]);
        const double lobe = (double)(gather_hemisphere_weight(h, i) * here[i]);
        sum.lobe += lobe;
        sum.light += lobe * (double)rgb_luminance(h->L[i]);
    }
    return sum;
}

// The magnitude of the Laplacian of the reflected light times step^2, over the light, without what
// noise explains. Only the differences from the mean radiance count: uniform light does not change.
static float laplacian(const struct lobe_at_record *l, const struct reflection *all,
                       const float *here, float step) {
    const struct gather_hemisphere *h = l->hemisphere;
    const float mean = (float)(all->light / all->lobe);
    double subset[RAY_SUBSETS] = {0}, sum = 0.0, noise = 0.0;
    for (size_t i = 0; i < h->all; i++) {
        if (!isfinite(h->ray[i].first.r)) continue;
        if (i < h->count && here[i] < REFLECTED_LEAST * all->most) continue;
        const float L = gather_hemisphere_weight(h, i) * (rgb_luminance(h->L[i]) - mean);
        subset[i % RAY_SUBSETS] += (double)(L * change_around(l, i, step, here[i]));
    }
    for (int i = 0; i < RAY_SUBSETS; i++) sum += subset[i];
    for (int i = 0; i < RAY_SUBSETS; i++)
        noise += (subset[i] - sum / RAY_SUBSETS) * (subset[i] - sum / RAY_SUBSETS);
    const double left = sum * sum - noise * RAY_SUBSETS / (RAY_SUBSETS - 1);
    // A circle of POINTS points has step^2 / 4 of the Laplacian as the mean of its differences.
    return left > 0.0 ? (float)(4.0 / POINTS * sqrt(left) / all->light) : 0.0f;
}

float fill_curvature_clamp_radius(const struct gather_hemisphere *h,
                                  const struct fill_glossy *glossy, float a, float R, float least) {
    const struct lobe_at_record l = {h, &glossy->brdf, glossy->wo};
    float *here = h->work;
    const struct reflection all = find_reflection(&l, here);
    const float most = LAPLACIAN_MOST * a * a;
    if (!(all.light > 0.0)) return R;
    for (int i = 0; i < SHRINK_STEPS && R > least; i++) {
        const float change = laplacian(&l, &all, here, a * R);
        if (!(change > most)) break;
        R *= fmaxf(sqrtf(most / change), SHRINK_LEAST);
    }
    return R;
}
