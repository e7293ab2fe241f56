// SPDX-License-Identifier: Apache-2.0
// Smooth glass: a boundary between two media, and a thin pane with both its boundaries at once;
// also the null BRDF. wo may be on either side. All have only delta lobes.
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_models.h"

// Fills reflection and transmission with probabilities f and 1 - f, which are the physical
// fractions without colours. A lobe of probability 0 is left out.
static int split_delta(float f, struct brdf_sample reflected, struct brdf_sample transmitted,
                       struct brdf_sample out[2]) {
    int n = 0;
    reflected.probability = f;
    transmitted.probability = 1.0f - f;
    if (f > 0.0f) out[n++] = reflected;
    if (f < 1.0f) out[n++] = transmitted;
    return n;
}

static int glass_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode,
                       struct brdf_sample out[2]) {
    if (wo.z == 0.0f) return 0;
    float cos_t, f = brdf_fresnel_dielectric(wo.z, b->ior, &cos_t);
    float eta = wo.z > 0.0f ? b->ior : 1.0f / b->ior;
    // Radiance is compressed to a smaller solid angle on the denser side.
    float t = (1.0f - f) / (mode == BRDF_RADIANCE ? eta * eta : 1.0f);
    struct brdf_sample transmitted = {.wi = v3(-wo.x / eta, -wo.y / eta, cos_t),
                                      .weight = rgb_scale(b->transmittance, t),
                                      .eta = eta,
                                      .lobe = BRDF_DELTA};
    return split_delta(f, brdf_mirror(wo, rgb_scale(b->specular, f)), transmitted, out);
}

// Light is reflected between the two boundaries: the series R + T R T + T R^3 T + ... = 2 R / (1 +
// R).
static int pane_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode,
                      struct brdf_sample out[2]) {
    (void)mode;
    if (wo.z == 0.0f) return 0;
    float f = brdf_fresnel_dielectric(fabsf(wo.z), b->ior, NULL);
    f = 2.0f * f / (1.0f + f);
    struct brdf_sample transmitted = {.wi = v3_neg(wo),
                                      .weight = rgb_scale(b->transmittance, 1.0f - f),
                                      .eta = 1.0f,
                                      .lobe = BRDF_DELTA};
    return split_delta(f, brdf_mirror(wo, rgb_scale(b->specular, f)), transmitted, out);
}

const struct brdf_model brdf_model_dielectric = {
    .name = "dielectric",
    .doc = "smooth glass or water: reflects and refracts",
    .lobes = BRDF_DELTA,
    .slots = 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_TRANSMITTANCE,
    .transmits = true,
    .delta = glass_delta,
};

const struct brdf_model brdf_model_thindielectric = {
    .name = "thindielectric",
    .doc = "thin pane of glass: reflects and lets through without bending",
    .lobes = BRDF_DELTA,
    .slots = 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_TRANSMITTANCE,
    .transmits = true,
    .thin = true,
    .delta = pane_delta,
};

static int null_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode,
                      struct brdf_sample out[2]) {
    (void)mode;
    out[0] = (struct brdf_sample){.wi = v3_neg(wo),
                                  .weight = b->transmittance,
                                  .probability = 1.0f,
                                  .eta = 1.0f,
                                  .lobe = BRDF_DELTA};
    return 1;
}

const struct brdf_model brdf_model_null = {
    .name = "null",
    .doc = "nothing: light goes straight on",
    .lobes = BRDF_DELTA,
    .transmits = true,
    .thin = true,
    .delta = null_delta,
};
