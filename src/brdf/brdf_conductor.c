// SPDX-License-Identifier: Apache-2.0
// Metals: the ideal mirror and its microfacet model [Walter et al. 2007], with complex indices of
// refraction per channel; `specular` is a factor.
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_microfacet.h"
#include "brdf/brdf_models.h"

static int conductor_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode,
                           struct brdf_sample out[2]) {
    (void)mode;
    if (!(wo.z > 0.0f)) return 0;
    out[0] = brdf_mirror(wo, rgb_mul(b->specular, brdf_fresnel_conductor(wo.z, b->eta, b->k)));
    return 1;
}

static struct microfacet conductor_facets(const struct brdf *b) {
    return brdf_microfacet_make(b->distribution, b->alpha_u, b->alpha_v, b->alpha_least);
}

static void conductor_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);  // cosine to the facet's normal
    rgb f = rgb_mul(b->specular, brdf_fresnel_conductor(cos_d, b->eta, b->k));
    *diffuse = rgb_grey(0.0f);
    *glossy = rgb_scale(f, brdf_microfacet_reflection(conductor_facets(b), wo, wi));
}

static void conductor_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                          float *glossy) {
    (void)lobes;
    *diffuse = 0.0f;
    *glossy = brdf_microfacet_reflection_pdf(conductor_facets(b), wo, wi);
}

static bool conductor_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    (void)lobes;
    return brdf_microfacet_reflect(conductor_facets(b), wo, u.y, u.z, wi);
}

static const struct brdf_model polished_conductor = {
    .name = "roughconductor",
    .doc = "polished metal: a delta lobe with the directions of facets",
    .lobes = BRDF_DELTA,
    .slots = 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_ETA | 1u << BRDF_SLOT_K,
    .polished = true,
    .eval = conductor_eval,
    .pdf = conductor_pdf,
    .sample_glossy = conductor_sample,
    .delta = conductor_delta,
};

const struct brdf_model brdf_model_conductor = {
    .name = "conductor",
    .doc = "smooth metal: an ideal mirror with the metal's Fresnel reflectance",
    .lobes = BRDF_DELTA,
    .slots = 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_ETA | 1u << BRDF_SLOT_K,
    .delta = conductor_delta,
};

const struct brdf_model brdf_model_roughconductor = {
    .name = "roughconductor",
    .doc = "rough metal: microfacets (GGX or Beckmann), isotropic or anisotropic",
    .lobes = BRDF_GLOSSY,
    .slots = 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_ETA | 1u << BRDF_SLOT_K |
             1u << BRDF_SLOT_ALPHA_U | 1u << BRDF_SLOT_ALPHA_V,
    .eval = conductor_eval,
    .pdf = conductor_pdf,
    .sample_glossy = conductor_sample,
    .if_polished = &polished_conductor,
};
