// SPDX-License-Identifier: Apache-2.0
// Rough glass: microfacets of a dielectric boundary that reflect and refract [Walter et al. 2007].
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_models.h"
#include "brdf/brdf_refraction.h"

static struct refraction rough_boundary(const struct brdf *b, vec3 *wo, vec3 *wi) {
    return brdf_refraction_at(
        brdf_microfacet_make(b->distribution, b->alpha_u, b->alpha_v, b->alpha_least), b->ior, wo,
        wi);
}

static void roughdielectric_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse,
                                 rgb *glossy) {
    struct refraction at = rough_boundary(b, &wo, &wi);
    float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
    float f = brdf_fresnel_dielectric(cos_d, at.eta, NULL) *
              brdf_microfacet_reflection(at.facets, wo, wi);
    *diffuse = rgb_grey(0.0f);
    *glossy = rgb_scale(b->specular, f);
}

static rgb rough_transmission(const struct brdf *b, vec3 wo, vec3 wi, enum brdf_mode mode) {
    struct refraction at = rough_boundary(b, &wo, &wi);
    return rgb_scale(b->transmittance, brdf_refraction_value(&at, wo, wi, mode));
}

static void roughdielectric_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes,
                                float *diffuse, float *glossy) {
    const bool both = (lobes & BRDF_GLOSSY) && (lobes & BRDF_THROUGH);
    struct refraction at = rough_boundary(b, &wo, &wi);
    *diffuse = 0.0f;
    if (wi.z > 0.0f) {
        float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
        *glossy = brdf_microfacet_reflection_pdf(at.facets, wo, wi) *
                  (both ? brdf_fresnel_dielectric(cos_d, at.eta, NULL) : 1.0f);
    } else {
        float f;
        *glossy = brdf_refraction_pdf(&at, wo, wi, &f);
        if (both) *glossy *= 1.0f - f;
    }
}

// Draws a visible facet, then reflection or refraction there in proportion to its Fresnel
// reflectance.
static bool roughdielectric_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u,
                                   vec3 *wi) {
    const bool below = wo.z < 0.0f;
    *wi = v3(0, 0, 0);
    struct refraction at = rough_boundary(b, &wo, wi);
    vec3 n = brdf_microfacet_sample(at.facets, wo, u.y, u.z);
    bool reflect = lobes & BRDF_GLOSSY;
    if (reflect && lobes & BRDF_THROUGH)
        reflect = u.x < brdf_fresnel_dielectric(v3_dot(wo, n), at.eta, NULL);
    if (!brdf_refraction_follow(&at, wo, n, !reflect, wi)) return false;
    if (below) wi->z = -wi->z;
    return true;
}

const struct brdf_model brdf_model_roughdielectric = {
    .name = "roughdielectric",
    .doc = "rough glass: microfacets (GGX or Beckmann) that reflect and refract",
    .lobes = BRDF_GLOSSY | BRDF_THROUGH,
    .slots = 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_TRANSMITTANCE | 1u << BRDF_SLOT_ALPHA_U |
             1u << BRDF_SLOT_ALPHA_V,
    .transmits = true,
    .eval = roughdielectric_eval,
    .through = rough_transmission,
    .pdf = roughdielectric_pdf,
    .sample_glossy = roughdielectric_sample,
};
