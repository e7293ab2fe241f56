// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: common to the two principled models [Burley 2012, 2015], as in Mitsuba 3: the
// diffuse lobe with retroreflection, flattening and sheen, Schlick's Fresnel factors with their
// tints, and roughness along two axes.
#ifndef BRDF_BURLEY_H
#define BRDF_BURLEY_H

#include "brdf/brdf.h"
#include "brdf/brdf_microfacet.h"

// Schlick's weight (1 - c)^5.
static inline float brdf_burley_weight(float c) {
    float m = clampf(1.0f - c, 0.0f, 1.0f), m2 = m * m;
    return m2 * m2 * m;
}

// Schlick's factor at the cosine c > 0, where the IOR of the other side over this one is eta:
// inside the denser medium it is that of the refracted cosine.
static inline float brdf_burley_schlick_weight(float c, float eta) {
    return brdf_burley_weight(eta > 1.0f ? c : safe_sqrtf(1.0f - (1.0f - c * c) / (eta * eta)));
}

// The base colour scaled to luminance 1.
static inline rgb brdf_burley_tint(const struct brdf *b) {
    float luminance = rgb_luminance(b->diffuse);
    return luminance > 0.0f ? rgb_scale(b->diffuse, 1.0f / luminance) : rgb_grey(1.0f);
}

// Schlick's reflectance of a dielectric tinted by the base colour.
static inline rgb brdf_burley_tinted(const struct brdf *b, float weight) {
    float r0 = sqrf((b->ior - 1.0f) / (b->ior + 1.0f));
    return rgb_mad(rgb_scale(brdf_burley_tint(b), r0 * (1.0f - weight)), rgb_grey(1.0f), weight);
}

// The microfacets of a roughness with the model's anisotropy.
static inline struct microfacet brdf_burley_facets(const struct brdf *b, float roughness) {
    float aspect = sqrtf(1.0f - 0.9f * minf(b->anisotropic, 1.0f)), a = sqrf(roughness);
    return brdf_microfacet_make(BRDF_GGX, a / aspect, a * aspect, maxf(0.001f, b->alpha_least));
}

// Computes integrals over the hemisphere for the albedo of the diffuse lobe.
satin_status brdf_burley_prepare(struct brdf *b, struct arena *arena);

// f_r of the diffuse lobe for both directions above, and its albedo, with the base colour times
// `base` and the sheen times `sheen`.
rgb brdf_burley_diffuse(const struct brdf *b, vec3 wo, vec3 wi, float base, float sheen);
rgb brdf_burley_diffuse_albedo(const struct brdf *b, float cosine, float base, float sheen);

#endif
