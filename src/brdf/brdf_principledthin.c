// SPDX-License-Identifier: Apache-2.0
// The principled model for thin sheets [Burley 2015] as in Mitsuba 3: a diffuse lobe on both sides,
// GGX facets that reflect, and GGX facets, made narrower by the IOR, that transmit light without
// changing its direction. Both sides are the same, so everything is computed with wo above.
// `diffuse` is the base colour, `ior` the IOR of the sheet, `alpha_u` the roughness.
#include "base/sampling.h"
#include "brdf/brdf_burley.h"
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_models.h"

static void mirror_up(vec3 *wo, vec3 *wi) {
    if (wo->z > 0.0f) return;
    wo->z = -wo->z;
    wi->z = -wi->z;
}

static struct microfacet thin_facets(const struct brdf *b) {
    return brdf_burley_facets(b, b->alpha_u);
}

static struct microfacet narrowed(const struct brdf *b) {
    return brdf_burley_facets(b, (0.65f * b->ior - 0.35f) * b->alpha_u);
}

static float diffuse_transmission(const struct brdf *b) {
    return (1.0f - b->spec_trans) * 0.5f * b->diff_trans;
}
static float diffuse_reflection(const struct brdf *b) {
    return (1.0f - b->spec_trans) * (1.0f - 0.5f * b->diff_trans);
}

// The cosine to the facet that reflects wo into wi.
static float facet_cosine(vec3 wo, vec3 wi) { return minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f); }

static void thin_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    mirror_up(&wo, &wi);
    *diffuse = brdf_burley_diffuse(b, wo, wi, diffuse_reflection(b), diffuse_reflection(b));
    *glossy = rgb_grey(0.0f);
    if (b->spec_trans == 0.0f) return;
    float c = facet_cosine(wo, wi), f = brdf_fresnel_dielectric(c, b->ior, NULL);
    rgb F = rgb_grey((1.0f - b->spec_tint) * f);
    if (b->spec_tint > 0.0f)
        F = rgb_mad(F, brdf_burley_tinted(b, brdf_burley_schlick_weight(c, b->ior)), b->spec_tint);
    *glossy = rgb_scale(F, b->spec_trans * brdf_microfacet_reflection(thin_facets(b), wo, wi));
    *glossy = rgb_mul(*glossy, b->specular);
}

static vec3 mirrored(vec3 w) { return v3(w.x, w.y, -w.z); }

// Whether light comes from behind the facet that reflects wo to the mirrored wi. Mitsuba does not
// test the same for wo, so this is the only function that is not reciprocal.
static bool lit_from_behind(vec3 wo, vec3 wi) {
    return v3_dot(wi, v3_add(wo, mirrored(wi))) < 0.0f;
}

static rgb thin_transmission(const struct brdf *b, vec3 wo, vec3 wi, enum brdf_mode mode) {
    vec3 eye = mode == BRDF_RADIANCE ? wo : wi, light = mode == BRDF_RADIANCE ? wi : wo;
    mirror_up(&eye, &light);
    float f = diffuse_transmission(b) * (1.0f / PI_F);
    if (b->spec_trans > 0.0f && lit_from_behind(eye, light)) {
        vec3 w = mirrored(light);
        float t = 1.0f - brdf_fresnel_dielectric(facet_cosine(eye, w), b->ior, NULL);
        f += b->spec_trans * t * brdf_microfacet_reflection(narrowed(b), eye, w);
    }
    return rgb_mul(rgb_scale(b->diffuse, f), b->transmittance);
}

// The probabilities that sample_glossy reflects and transmits at facets; otherwise it transmits
// diffusely.
static void thin_choose(const struct brdf *b, unsigned lobes, float *reflect, float *pass) {
    *reflect = lobes & BRDF_GLOSSY ? 0.5f * b->spec_trans : 0.0f;
    *pass = lobes & BRDF_THROUGH ? 0.5f * b->spec_trans : 0.0f;
    float sum = *reflect + *pass + (lobes & BRDF_THROUGH ? diffuse_transmission(b) : 0.0f);
    float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
    *reflect *= scale;
    *pass *= scale;
}

static void thin_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                     float *glossy) {
    float reflect, pass;
    mirror_up(&wo, &wi);
    thin_choose(b, lobes, &reflect, &pass);
    *diffuse = maxf(wi.z, 0.0f) * (1.0f / PI_F);
    if (wi.z > 0.0f) {
        *glossy = reflect > 0.0f ? reflect * brdf_microfacet_reflection_pdf(thin_facets(b), wo, wi)
                                 : 0.0f;
        return;
    }
    *glossy = (1.0f - reflect - pass) * -wi.z * (1.0f / PI_F);
    if (pass > 0.0f)
        *glossy += pass * brdf_microfacet_reflection_pdf(narrowed(b), wo, mirrored(wi));
}

static bool thin_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    const bool below = wo.z < 0.0f;
    float reflect, pass;
    *wi = v3(0, 0, 0);
    mirror_up(&wo, wi);
    thin_choose(b, lobes, &reflect, &pass);
    if (u.x < reflect) {
        if (!brdf_microfacet_reflect(thin_facets(b), wo, u.y, u.z, wi)) return false;
    } else {
        if (u.x >= reflect + pass)
            *wi = sample_cosine_hemisphere(u.y, u.z);
        else if (!brdf_microfacet_reflect(narrowed(b), wo, u.y, u.z, wi))
            return false;
        wi->z = -wi->z;
    }
    if (below) wi->z = -wi->z;
    return true;
}

static rgb thin_diffuse_albedo(const struct brdf *b, vec3 wo) {
    return brdf_burley_diffuse_albedo(b, fabsf(wo.z), diffuse_reflection(b), diffuse_reflection(b));
}

static rgb thin_glossy_estimate(const struct brdf *b, vec3 wo, unsigned lobe) {
    float f = brdf_fresnel_dielectric(maxf(fabsf(wo.z), 0.05f), b->ior, NULL);
    if (lobe == BRDF_GLOSSY) return rgb_grey(b->spec_trans * f);
    return rgb_scale(b->diffuse, b->spec_trans * (1.0f - f) + diffuse_transmission(b));
}

static void thin_probabilities(const struct brdf *b, vec3 wo, float *diffuse, float *glossy,
                               float *delta) {
    (void)wo;
    float mean = rgb_mean(b->diffuse);
    *delta = 0.0f;
    *diffuse = diffuse_reflection(b) * (mean + 0.2f * b->sheen);
    *glossy = b->spec_trans + diffuse_transmission(b) * mean;
}

const struct brdf_model brdf_model_principledthin = {
    .name = "principledthin",
    .doc = "Burley's model for thin sheets: both sides scatter and let light through",
    .lobes = BRDF_SMOOTH,
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_ALPHA_U | 1u << BRDF_SLOT_ANISOTROPIC |
             1u << BRDF_SLOT_SPEC_TRANS | 1u << BRDF_SLOT_SPEC_TINT | 1u << BRDF_SLOT_SHEEN |
             1u << BRDF_SLOT_SHEEN_TINT | 1u << BRDF_SLOT_FLATNESS | 1u << BRDF_SLOT_DIFF_TRANS |
             1u << BRDF_SLOT_IOR,
    .transmits = true,
    .thin = true,
    .prepare = brdf_burley_prepare,
    .eval = thin_eval,
    .through = thin_transmission,
    .pdf = thin_pdf,
    .diffuse_albedo = thin_diffuse_albedo,
    .glossy_estimate = thin_glossy_estimate,
    .sample_glossy = thin_sample,
    .probabilities = thin_probabilities,
};
