// SPDX-License-Identifier: Apache-2.0
// Sampling of visible normals: stretches wo so that the facets are isotropic with roughness
// 1, draws a visible slope there, and shrinks it back [Heitz 2014].
#include "brdf/brdf_microfacet.h"

#include "base/sampling.h"

float brdf_microfacet_g1_exact(struct microfacet m, vec3 v) {
    float t2 = brdf_microfacet_stretch2(m, v);
    if (m.kind == BRDF_GGX) return 2.0f * v.z / (v.z + sqrtf(v.z * v.z + t2));
    if (v.z * v.z >= 25.0f * t2) return 1.0f;  // the error is 1e-13
    float a = v.z / sqrtf(t2);
    return 2.0f * a / (a * (1.0f + erff(a)) + expf(-a * a) * (1.0f / 1.7724538509f));
}

// Inverse error function by Winitzki's closed form, with errors up to 5e-3.
static double inverse_erf_roughly(double y) {
    double l = log1p(-y * y), b = 2.0 / (M_PI * 0.147) + 0.5 * l;
    return copysign(sqrt(sqrt(b * b - l / 0.147) - b), y);
}

// One step of Halley's method, with erf'' = -2 x erf', reduces the error to 4e-7.
static double inverse_erf(double y) {
    y = fmin(fmax(y, -1.0 + 1e-8), 1.0 - 1e-8);
    double x = inverse_erf_roughly(y), step = (erf(x) - y) * exp(x * x) / M_2_SQRTPI;
    return x - step / (1.0 + x * step);
}

// The slope along wo of a visible Beckmann facet of roughness 1, viewed at an angle of cosine
// c and sine s to the normal. Its density is (c - s x) exp(-x^2) up to x = c / s, so the
// distribution function has a closed form. It is inverted by Halley's method within a bracket, in
// two steps on average, from a blend of the solutions for c = 1 and c = 0. Accurate to 1e-8 in u.
static double beckmann_slope(double c, double s, double u) {
    const double q = 0.25 * M_2_SQRTPI;  // 1 / (2 sqrt(pi))
    double lo = -5.0, hi = s > 0.2 * c ? c / s : 5.0;
    u = fmin(fmax(u, 1e-9), 1.0 - 1e-9);
    double below = 1.0 + erf(hi), target = u * (0.5 * c * below + q * s * exp(-hi * hi));
    double x = c * c * inverse_erf_roughly(u * below - 1.0) - s * s * sqrt(-log(u));
    if (!(x > lo && x < hi)) x = 0.5 * (lo + hi);
    for (int i = 0; i < 24; i++) {
        double e = exp(-x * x), facing = c - s * x;
        double excess = 0.5 * c * (1.0 + erf(x)) + q * s * e - target;
        if (excess > 0.0)
            hi = x;
        else
            lo = x;
        double step = excess / (2.0 * q * e * facing);
        double next = x - step / (1.0 + step * (x + 0.5 * s / facing));
        if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
        if (fabs(next - x) < 1e-3) return next;  // a step cubes the error
        x = next;
    }
    return x;
}

// A visible slope of isotropic GGX facets of roughness 1, first along wo: the projected
// hemisphere is a disk whose far half is foreshortened [Heitz 2018].
static vec2 ggx_slope(float c, float s, float u, float v) {
    vec2 p = sample_disk(u, v);
    p.y = lerpf(safe_sqrtf(1.0f - p.x * p.x), p.y, 0.5f * (1.0f + c));
    float z = safe_sqrtf(1.0f - p.x * p.x - p.y * p.y);
    float scale = 1.0f / maxf(s * p.y + c * z, 1e-12f);
    return (vec2){(c * p.y - s * z) * scale, p.x * scale};
}

// wo after stretching: cosine and sine to the normal, and its azimuth.
struct stretched_direction {
    float c, s, cos_phi, sin_phi;
};

static struct stretched_direction stretch(struct microfacet m, vec3 w) {
    vec3 t = v3_unit(v3(m.au * w.x, m.av * w.y, w.z));
    float s = sqrtf(t.x * t.x + t.y * t.y);
    if (!(s > 0.0f)) return (struct stretched_direction){1.0f, 0.0f, 1.0f, 0.0f};
    return (struct stretched_direction){t.z, s, t.x / s, t.y / s};
}

static vec3 shrink_slope(struct microfacet m, struct stretched_direction w, vec2 slope) {
    float x = w.cos_phi * slope.x - w.sin_phi * slope.y;
    float y = w.sin_phi * slope.x + w.cos_phi * slope.y;
    return v3_unit(v3(-m.au * x, -m.av * y, 1.0f));
}

vec3 brdf_microfacet_sample(struct microfacet m, vec3 w, float u, float v) {
    struct stretched_direction stretched = stretch(m, w);
    vec2 slope = m.kind == BRDF_GGX ? ggx_slope(stretched.c, stretched.s, u, v)
                                    : (vec2){(float)beckmann_slope(stretched.c, stretched.s, v),
                                             (float)inverse_erf(2.0 * u - 1.0)};
    return shrink_slope(m, stretched, slope);
}

// u -> 1 - u mirrors both maps from (u, v) to slopes, so half of the rule is enough. Beckmann's map
// is separable, so a root is needed per node, not per pair of nodes.
double brdf_microfacet_visible_mean(struct microfacet m, float cosine,
                                    const struct quadrature *rule,
                                    float (*fn)(const void *ctx, vec3 n), const void *ctx) {
    struct stretched_direction stretched =
        stretch(m, v3(safe_sqrtf(1.0f - cosine * cosine), 0.0f, cosine));
    vec2 slope[QUADRATURE_MAX];
    for (int i = 0; i < rule->count && m.kind == BRDF_BECKMANN; i++)
        slope[i] = (vec2){(float)beckmann_slope(stretched.c, stretched.s, rule->x[i]),
                          (float)inverse_erf(2.0 * rule->x[i] - 1.0)};
    double sum = 0.0;
    for (int i = 0; i < (rule->count + 1) / 2; i++) {
        double row = 0.0;
        for (int j = 0; j < rule->count; j++) {
            vec2 at = m.kind == BRDF_GGX ? ggx_slope(stretched.c, stretched.s, (float)rule->x[i],
                                                     (float)rule->x[j])
                                         : (vec2){slope[j].x, slope[i].y};
            row += rule->weight[j] * (double)fn(ctx, shrink_slope(m, stretched, at));
        }
        sum += (2 * i + 1 == rule->count ? 1.0 : 2.0) * rule->weight[i] * row;
    }
    return sum;
}

bool brdf_microfacet_reflect(struct microfacet m, vec3 wo, float u, float v, vec3 *wi) {
    vec3 n = brdf_microfacet_sample(m, wo, u, v);
    *wi = v3_mad(v3_neg(wo), 2.0f * v3_dot(wo, n), n);
    return wi->z > 0.0f;
}
