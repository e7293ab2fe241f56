// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: distributions of microfacet normals, their Smith shadowing, and sampling of
// visible normals. Sources: [Walter et al. 2007] for D and G, [Heitz 2014] for the anisotropic
// forms, [Heitz 2018] and [Jakob 2014] for sampling.
//
// Deviation: the shadowing of Beckmann facets is evaluated by Walter's rational fit (0.35 %), as is
// usual, but densities of sampling are by the exact form, which the sampler follows.
#ifndef BRDF_MICROFACET_H
#define BRDF_MICROFACET_H

#include "base/vec.h"
#include "brdf/brdf.h"
#include "brdf/brdf_quadrature.h"

struct microfacet {
    enum brdf_distribution kind;
    float au, av;  // roughness along x and y, >= 1e-4
};

static inline struct microfacet brdf_microfacet_make(enum brdf_distribution kind, float au,
                                                     float av, float least) {
    least = maxf(least, 1e-4f);
    return (struct microfacet){kind, maxf(au, least), maxf(av, least)};
}

// |(au v.x, av v.y)|^2: the squared tangent of v after stretching, times v.z^2.
static inline float brdf_microfacet_stretch2(struct microfacet m, vec3 v) {
    return sqrf(m.au * v.x) + sqrf(m.av * v.y);
}

// The density of facets with normal h / |h| [sr^-1]; h need not be unit, h.z > 0.
static inline float brdf_microfacet_d(struct microfacet m, vec3 h) {
    float h2 = v3_len2(h), e = sqrf(h.x / m.au) + sqrf(h.y / m.av), z2 = h.z * h.z;
    float scale = h2 * h2 / (PI_F * m.au * m.av);
    if (m.kind == BRDF_GGX) return scale / sqrf(e + z2);
    return scale * expf(-e / z2) / (z2 * z2);
}

// The masking of direction v (v.z > 0), by the rational fit: the fraction of the facets facing v
// that is visible from v.
static inline float brdf_microfacet_g1(struct microfacet m, vec3 v) {
    float t2 = brdf_microfacet_stretch2(m, v);
    if (m.kind == BRDF_GGX) return 2.0f * v.z / (v.z + sqrtf(v.z * v.z + t2));
    if (v.z * v.z >= 2.56f * t2) return 1.0f;
    float a = v.z / sqrtf(t2);
    return a * (3.535f + 2.181f * a) / (1.0f + a * (2.276f + 2.577f * a));
}

// The exact masking of v (v.z > 0), which normalises the distribution of visible normals.
float brdf_microfacet_g1_exact(struct microfacet m, vec3 v);

// D G / (4 cos cos) for reflection from wo to wi, both above [sr^-1].
static inline float brdf_microfacet_reflection(struct microfacet m, vec3 wo, vec3 wi) {
    float d = brdf_microfacet_d(m, v3_add(wo, wi));
    if (m.kind == BRDF_GGX) {
        float lo = wo.z + sqrtf(wo.z * wo.z + brdf_microfacet_stretch2(m, wo));
        float li = wi.z + sqrtf(wi.z * wi.z + brdf_microfacet_stretch2(m, wi));
        return d / (lo * li);
    }
    return d * brdf_microfacet_g1(m, wo) * brdf_microfacet_g1(m, wi) / (4.0f * wo.z * wi.z);
}

// The density over the solid angle of wi with which reflection of wo at a visible normal draws wi.
static inline float brdf_microfacet_reflection_pdf(struct microfacet m, vec3 wo, vec3 wi) {
    return brdf_microfacet_d(m, v3_add(wo, wi)) * brdf_microfacet_g1_exact(m, wo) / (4.0f * wo.z);
}

// Draws a unit normal that is visible from w (w.z > 0), with density D G1 (w . m) / w.z.
vec3 brdf_microfacet_sample(struct microfacet m, vec3 w, float u, float v);

// The mean of fn over the normals that are visible at `cosine` from the azimuth 0, for isotropic
// facets and a function that is even in y: a product Gauss rule over the unit square of
// brdf_microfacet_sample.
double brdf_microfacet_visible_mean(struct microfacet m, float cosine,
                                    const struct quadrature *rule,
                                    float (*fn)(const void *ctx, vec3 n), const void *ctx);

// Reflects wo at a visible normal. False if the result is not above.
bool brdf_microfacet_reflect(struct microfacet m, vec3 wo, float u, float v, vec3 *wi);

#endif
