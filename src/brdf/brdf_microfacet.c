// SPDX-License-Identifier: Apache-2.0
// Sampling of visible normals: stretch the view so that the facets become isotropic with roughness
// 1, draw a visible slope there, shrink back [Heitz 2014].
#include "brdf/brdf_microfacet.h"

#include "base/sampling.h"

float microfacet_g1_exact(struct microfacet m, vec3 v) {
    float t2 = microfacet_stretch2(m, v);
    if (m.kind == BRDF_GGX) return 2.0f * v.z / (v.z + sqrtf(v.z * v.z + t2));
    if (v.z * v.z >= 25.0f * t2) return 1.0f;  // 1 - 1e-13
    float a = v.z / sqrtf(t2);
    return 2.0f * a / (a * (1.0f + erff(a)) + expf(-a * a) * (1.0f / 1.7724538509f));
}

// Inverse error function: Winitzki's closed form (2e-3), then two steps of Halley's method, with
// erf'' = -2 x erf'.
static double inverse_erf(double y) {
    y = fmin(fmax(y, -1.0 + 1e-8), 1.0 - 1e-8);
    double l = log1p(-y * y), b = 2.0 / (M_PI * 0.147) + 0.5 * l;
    double x = copysign(sqrt(sqrt(b * b - l / 0.147) - b), y);
    for (int i = 0; i < 2; i++) {
        double step = (erf(x) - y) * exp(x * x) / M_2_SQRTPI;
        x -= step / (1.0 + x * step);
    }
    return x;
}

// The slope along the view of a visible Beckmann facet of roughness 1, seen under an angle of
// cosine c and sine s to the normal. Its density is (c - s x) exp(-x^2) up to x = c / s, so its
// distribution is closed, and inverted by Newton's method kept inside a bracket.
static double beckmann_slope(double c, double s, double u) {
    const double q = 0.25 * M_2_SQRTPI;  // 1 / (2 sqrt(pi))
    double lo = -5.0, hi = s > 0.2 * c ? c / s : 5.0;
    double below = 1.0 + erf(hi);
    double target = u * (0.5 * c * below + q * s * exp(-hi * hi));
    double x = inverse_erf(u * below - 1.0);
    for (int i = 0; i < 24; i++) {
        double e = exp(-x * x);
        double excess = 0.5 * c * (1.0 + erf(x)) + q * s * e - target;
        if (excess > 0.0)
            hi = x;
        else
            lo = x;
        double next = x - excess / (2.0 * q * e * (c - s * x));
        if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
        if (fabs(next - x) < 1e-7) return next;
        x = next;
    }
    return x;
}

// A visible slope of isotropic GGX facets of roughness 1, first along the view: the projected
// hemisphere is a disk whose far half is foreshortened [Heitz 2018].
static vec2 ggx_slope(float c, float s, float u, float v) {
    vec2 p = sample_disk(u, v);
    p.y = lerpf(safe_sqrtf(1.0f - p.x * p.x), p.y, 0.5f * (1.0f + c));
    float z = safe_sqrtf(1.0f - p.x * p.x - p.y * p.y);
    float scale = 1.0f / fmaxf(s * p.y + c * z, 1e-12f);
    return (vec2){(c * p.y - s * z) * scale, p.x * scale};
}

vec3 microfacet_sample(struct microfacet m, vec3 w, float u, float v) {
    vec3 stretched = v3_unit(v3(m.au * w.x, m.av * w.y, w.z));
    float s = sqrtf(sqrf(stretched.x) + sqrf(stretched.y)), c = stretched.z;
    float cos_phi = s > 0.0f ? stretched.x / s : 1.0f, sin_phi = s > 0.0f ? stretched.y / s : 0.0f;
    vec2 slope;
    if (m.kind == BRDF_GGX)
        slope = ggx_slope(c, s, u, v);
    else
        slope = (vec2){(float)beckmann_slope(c, s, u), (float)inverse_erf(2.0 * v - 1.0)};
    float x = cos_phi * slope.x - sin_phi * slope.y, y = sin_phi * slope.x + cos_phi * slope.y;
    return v3_unit(v3(-m.au * x, -m.av * y, 1.0f));
}

bool microfacet_reflect(struct microfacet m, vec3 wo, float u, float v, vec3 *wi) {
    vec3 n = microfacet_sample(m, wo, u, v);
    *wi = v3_mad(v3_neg(wo), 2.0f * v3_dot(wo, n), n);
    return wi->z > 0.0f;
}
