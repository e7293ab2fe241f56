// SPDX-License-Identifier: Apache-2.0
// What is common to the two principled models [Burley 2012, 2015], as Mitsuba 3 has it: the diffuse
// lobe with its retroreflection, flattening and sheen, Schlick's Fresnel factors with their tints,
// and roughness along two axes. Private to brdf/.
#ifndef BRDF_BURLEY_H
#define BRDF_BURLEY_H

#include "brdf/brdf.h"
#include "brdf/brdf_microfacet.h"

// Schlick's weight (1 - c)^5.
static inline float burley_weight(float c) {
    float m = clampf(1.0f - c, 0.0f, 1.0f), m2 = m * m;
    return m2 * m2 * m;
}

// Schlick's factor at the cosine c > 0 where the relative index beyond is eta: from inside the
// denser medium by the refracted cosine.
static inline float burley_schlick_weight(float c, float eta) {
    return burley_weight(eta > 1.0f ? c : safe_sqrtf(1.0f - (1.0f - c * c) / (eta * eta)));
}

// The base colour at luminance 1.
static inline rgb burley_tint(const struct brdf *b) {
    float luminance = rgb_luminance(b->diffuse);
    return luminance > 0.0f ? rgb_scale(b->diffuse, 1.0f / luminance) : rgb_grey(1.0f);
}

// Schlick's reflectance of a dielectric tinted by the base colour.
static inline rgb burley_tinted(const struct brdf *b, float weight) {
    float r0 = sqrf((b->ior - 1.0f) / (b->ior + 1.0f));
    return rgb_mad(rgb_scale(burley_tint(b), r0 * (1.0f - weight)), rgb_grey(1.0f), weight);
}

// The facets of a roughness, by the model's anisotropy.
static inline struct microfacet burley_facets(const struct brdf *b, float roughness) {
    float aspect = sqrtf(1.0f - 0.9f * minf(b->anisotropic, 1.0f)), a = sqrf(roughness);
    return microfacet_make(BRDF_GGX, a / aspect, a * aspect, maxf(0.001f, b->alpha_least));
}

// Integrals over the hemisphere for the albedo of the diffuse lobe.
satin_status burley_prepare(struct brdf *b, struct arena *arena);

// The diffuse lobe's f_r, both directions above, and its albedo: base colour's fraction times
// `base`, sheen times `sheen`.
rgb burley_diffuse(const struct brdf *b, vec3 wo, vec3 wi, float base, float sheen);
rgb burley_diffuse_albedo(const struct brdf *b, float cosine, float base, float sheen);

#endif
