// SPDX-License-Identifier: Apache-2.0
// Lambertian reflection, diffuse / pi, and functions for all models with such a lobe.
#include "brdf/brdf_models.h"

static void diffuse_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    (void)wo, (void)wi;
    *diffuse = rgb_scale(b->diffuse, 1.0f / PI_F);
    *glossy = rgb_grey(0.0f);
}

void brdf_diffuse_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                      float *glossy) {
    (void)b, (void)wo, (void)lobes;
    *diffuse = wi.z * (1.0f / PI_F);
    *glossy = 0.0f;
}

void brdf_mean_probabilities(const struct brdf *b, vec3 wo, float *diffuse, float *glossy,
                             float *delta) {
    (void)wo;
    *diffuse = rgb_mean(b->diffuse);
    *glossy = rgb_mean(b->specular);
    *delta = 0.0f;
}

const struct brdf_model brdf_model_diffuse = {
    .name = "diffuse",
    .doc = "Lambertian: scatters light equally into all directions",
    .lobes = BRDF_DIFFUSE,
    .slots = 1u << BRDF_SLOT_DIFFUSE,
    .eval = diffuse_eval,
    .pdf = brdf_diffuse_pdf,
};
