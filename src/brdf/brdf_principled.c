// SPDX-License-Identifier: Apache-2.0
// The principled model [Burley 2012, 2015] as in Mitsuba 3: a diffuse lobe (brdf_burley.c), GGX
// facets with a Fresnel factor between those of a dielectric and a metal, a clear coat of GTR1
// facets, and refraction through the same GGX facets. `diffuse` is the base colour, `ior` the
// relative IOR, `alpha_u` the roughness. There is reflection inside only if light can enter
// (spec_trans).
#include "brdf/brdf_burley.h"
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_models.h"
#include "brdf/brdf_refraction.h"

// The fractions of the base that are diffuse and that refract.
static float diffuse_fraction(const struct brdf *b) {
    return (1.0f - b->metallic) * (1.0f - b->spec_trans);
}
static float refracting_fraction(const struct brdf *b) {
    return (1.0f - b->metallic) * b->spec_trans;
}

// The reflectance of the facets from outside, at the cosine c to them.
static rgb reflectance(const struct brdf *b, float c) {
    float dielectric = (1.0f - b->metallic) * (1.0f - b->spec_tint);
    rgb f = rgb_grey(dielectric * brdf_fresnel_dielectric(c, b->ior, NULL));
    if (b->metallic == 0.0f && b->spec_tint == 0.0f) return f;
    float w = brdf_burley_schlick_weight(c, b->ior);
    rgb metal = rgb_mad(rgb_scale(b->diffuse, 1.0f - w), rgb_grey(1.0f), w);
    f = rgb_mad(f, metal, b->metallic);
    return rgb_mad(f, brdf_burley_tinted(b, w), (1.0f - b->metallic) * b->spec_tint);
}

// ---- The clear coat -----------------------------------------------------------------------------

static float coat_alpha2(const struct brdf *b) {
    return sqrf(maxf(lerpf(0.1f, 0.001f, b->clearcoat_gloss), b->alpha_least));
}

// The density of GTR1 facets whose normal has cosine z.
static float coat_d(float alpha2, float z) {
    return (alpha2 - 1.0f) / (PI_F * logf(alpha2) * (1.0f + (alpha2 - 1.0f) * z * z));
}

static float coat_g1(float z) { return 2.0f * z / (z + sqrtf(z * z + 0.0625f * (1.0f - z * z))); }

static float clear_coat(const struct brdf *b, vec3 wo, vec3 wi) {
    vec3 h = v3_unit(v3_add(wo, wi));
    float w = brdf_burley_schlick_weight(v3_dot(wo, h), b->ior);
    float f = lerpf(0.04f, 1.0f, w) * coat_d(coat_alpha2(b), h.z) * coat_g1(wo.z) * coat_g1(wi.z);
    return 0.25f * b->clearcoat * f;
}

static float coat_pdf(const struct brdf *b, vec3 wo, vec3 wi) {
    vec3 h = v3_unit(v3_add(wo, wi));
    return coat_d(coat_alpha2(b), h.z) * h.z / (4.0f * v3_dot(wo, h));
}

static bool coat_sample(const struct brdf *b, vec3 wo, vec3 u, vec3 *wi) {
    float alpha2 = coat_alpha2(b), phi = 2.0f * PI_F * u.y;
    float z2 = (1.0f - powf(alpha2, 1.0f - u.z)) / (1.0f - alpha2), s = safe_sqrtf(1.0f - z2);
    vec3 h = v3(s * cosf(phi), s * sinf(phi), safe_sqrtf(z2));
    float c = v3_dot(wo, h);
    *wi = v3_mad(v3_neg(wo), 2.0f * c, h);
    return c > 0.0f && wi->z > 0.0f;
}

// The probability that sample_glossy draws from the clear coat.
static float coat_probability(const struct brdf *b, bool inside, unsigned lobes) {
    if (inside || !(lobes & BRDF_GLOSSY)) return 0.0f;
    return 0.25f * b->clearcoat / (1.0f + 0.25f * b->clearcoat);
}

// ---- All lobes ----------------------------------------------------------------------------------

static struct refraction facets_at(const struct brdf *b, vec3 *wo, vec3 *wi) {
    return brdf_refraction_at(brdf_burley_facets(b, b->alpha_u), b->ior, wo, wi);
}

static void principled_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    const bool inside = wo.z < 0.0f;
    struct refraction at = facets_at(b, &wo, &wi);
    float c = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
    float d = brdf_microfacet_reflection(at.facets, wo, wi);
    *diffuse = rgb_grey(0.0f);
    if (inside) {
        *glossy = rgb_grey(refracting_fraction(b) * brdf_fresnel_dielectric(c, at.eta, NULL) * d);
        return;
    }
    *diffuse = brdf_burley_diffuse(b, wo, wi, diffuse_fraction(b), 1.0f - b->metallic);
    *glossy = rgb_scale(reflectance(b, c), d);
    if (b->clearcoat > 0.0f) *glossy = rgb_add(*glossy, rgb_grey(clear_coat(b, wo, wi)));
    *glossy = rgb_mul(*glossy, b->specular);
}

static rgb principled_transmission(const struct brdf *b, vec3 wo, vec3 wi, enum brdf_mode mode) {
    struct refraction at = facets_at(b, &wo, &wi);
    float f = refracting_fraction(b) * brdf_refraction_value(&at, wo, wi, mode);
    rgb root = rgb_make(sqrtf(b->diffuse.r), sqrtf(b->diffuse.g), sqrtf(b->diffuse.b));
    return rgb_mul(rgb_scale(root, f), b->transmittance);
}

// The probability that a facet of reflectance f refracts.
static float refracts(const struct brdf *b, bool inside, unsigned lobes, float f) {
    if (!(lobes & BRDF_THROUGH)) return 0.0f;
    if (!(lobes & BRDF_GLOSSY)) return 1.0f;
    return (inside ? 1.0f : refracting_fraction(b)) * (1.0f - f);
}

static void principled_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                           float *glossy) {
    const bool inside = wo.z < 0.0f;
    const float coated = coat_probability(b, inside, lobes);
    struct refraction at = facets_at(b, &wo, &wi);
    *diffuse = wi.z > 0.0f && !inside ? wi.z * (1.0f / PI_F) : 0.0f;
    *glossy = 0.0f;
    if (wi.z > 0.0f && lobes & BRDF_GLOSSY) {
        float c = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
        float f = brdf_fresnel_dielectric(c, at.eta, NULL);
        *glossy = (1.0f - coated) * (1.0f - refracts(b, inside, lobes, f)) *
                  brdf_microfacet_reflection_pdf(at.facets, wo, wi);
        if (coated > 0.0f) *glossy += coated * coat_pdf(b, wo, wi);
    } else if (wi.z < 0.0f) {
        float f, visible = brdf_refraction_pdf(&at, wo, wi, &f);
        *glossy = (1.0f - coated) * refracts(b, inside, lobes, f) * visible;
    }
}

static bool principled_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    const bool inside = wo.z < 0.0f;
    const float coated = coat_probability(b, inside, lobes);
    if (u.x < coated) return coat_sample(b, wo, u, wi);
    float rest = (u.x - coated) / (1.0f - coated);
    *wi = v3(0, 0, 0);
    struct refraction at = facets_at(b, &wo, wi);
    vec3 n = brdf_microfacet_sample(at.facets, wo, u.y, u.z);
    float f = brdf_fresnel_dielectric(v3_dot(wo, n), at.eta, NULL);
    if (!brdf_refraction_follow(&at, wo, n, rest < refracts(b, inside, lobes, f), wi)) return false;
    if (inside) wi->z = -wi->z;
    return true;
}

static rgb principled_diffuse_albedo(const struct brdf *b, vec3 wo) {
    if (!(wo.z > 0.0f)) return rgb_grey(0.0f);
    return brdf_burley_diffuse_albedo(b, wo.z, diffuse_fraction(b), 1.0f - b->metallic);
}

// Estimated by the reflectance of facets whose normal is that of the surface.
static rgb principled_glossy_estimate(const struct brdf *b, vec3 wo, unsigned lobe) {
    float c = maxf(fabsf(wo.z), 0.05f),
          f = brdf_fresnel_dielectric(copysignf(c, wo.z), b->ior, NULL);
    if (lobe == BRDF_THROUGH) {
        rgb root = rgb_make(sqrtf(b->diffuse.r), sqrtf(b->diffuse.g), sqrtf(b->diffuse.b));
        return rgb_scale(root, refracting_fraction(b) * (1.0f - f));
    }
    if (wo.z < 0.0f) return rgb_grey(refracting_fraction(b) * f);
    float w = brdf_burley_schlick_weight(c, b->ior);
    return rgb_add(reflectance(b, c), rgb_grey(0.25f * b->clearcoat * lerpf(0.04f, 1.0f, w)));
}

static void principled_probabilities(const struct brdf *b, vec3 wo, float *diffuse, float *glossy,
                                     float *delta) {
    *delta = 0.0f;
    *diffuse = 0.0f;
    *glossy = 1.0f;
    if (!(wo.z > 0.0f)) return;
    rgb g = rgb_add(principled_glossy_estimate(b, wo, BRDF_GLOSSY),
                    principled_glossy_estimate(b, wo, BRDF_THROUGH));
    *diffuse = diffuse_fraction(b) * rgb_mean(b->diffuse) + 0.2f * (1.0f - b->metallic) * b->sheen;
    *glossy = clampf(rgb_mean(g), 0.1f, 1.0f);
}

const struct brdf_model brdf_model_principled = {
    .name = "principled",
    .doc = "Burley's model: diffuse, metal, coat, sheen and refraction by a few numbers",
    .lobes = BRDF_SMOOTH,
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_ALPHA_U | 1u << BRDF_SLOT_METALLIC |
             1u << BRDF_SLOT_ANISOTROPIC | 1u << BRDF_SLOT_SPEC_TRANS | 1u << BRDF_SLOT_SPEC_TINT |
             1u << BRDF_SLOT_SHEEN | 1u << BRDF_SLOT_SHEEN_TINT | 1u << BRDF_SLOT_FLATNESS |
             1u << BRDF_SLOT_CLEARCOAT | 1u << BRDF_SLOT_CLEARCOAT_GLOSS,
    .transmits = true,
    .prepare = brdf_burley_prepare,
    .eval = principled_eval,
    .through = principled_transmission,
    .pdf = principled_pdf,
    .diffuse_albedo = principled_diffuse_albedo,
    .glossy_estimate = principled_glossy_estimate,
    .sample_glossy = principled_sample,
    .probabilities = principled_probabilities,
};
