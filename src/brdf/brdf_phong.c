// SPDX-License-Identifier: Apache-2.0
// The modified Phong model [Lafortune and Willems 1994]: diffuse / pi + specular (n + 2) / (2 pi)
// cos^n(angle between wi and the mirror direction). Its albedo is at most 1 if diffuse + specular
// is.
#include "base/frame.h"
#include "brdf/brdf_models.h"

// x^n for 0 <= x <= 1 and n >= 0. Integer exponents, the usual case, by squaring.
static float power(float x, float n) {
    int whole = n <= 1024.0f ? (int)n : -1;
    if ((float)whole != n) return powf(x, n);
    float r = 1.0f;
    for (; whole; whole >>= 1, x *= x)
        if (whole & 1) r *= x;
    return r;
}

// The exponent of the lobe, limited by alpha_least: facets of roughness alpha spread light like an
// exponent of 2 / alpha^2 - 2 [Walter et al. 2007].
static float exponent(const struct brdf *b) {
    if (!(b->alpha_least > 0.0f)) return b->exponent;
    return minf(b->exponent, 2.0f / sqrf(b->alpha_least) - 2.0f);
}

// cos^n of the angle between wi and the reflection of wo.
static float lobe(const struct brdf *b, vec3 wo, vec3 wi) {
    float c = wo.z * wi.z - wo.x * wi.x - wo.y * wi.y;
    return c > 0.0f ? power(minf(c, 1.0f), exponent(b)) : 0.0f;
}

static void phong_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    float f = (exponent(b) + 2.0f) * (0.5f / PI_F) * lobe(b, wo, wi);
    *diffuse = rgb_scale(b->diffuse, 1.0f / PI_F);
    *glossy = rgb_scale(b->specular, f);
}

static void phong_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                      float *glossy) {
    (void)lobes;
    *diffuse = wi.z * (1.0f / PI_F);
    *glossy = (exponent(b) + 1.0f) * (0.5f / PI_F) * lobe(b, wo, wi);
}

// Draws by cos^n around the mirror direction. Samples below the surface fail.
static bool phong_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    (void)lobes;
    float l = logf(maxf(1.0f - u.y, 0x1p-25f)) / (exponent(b) + 1.0f);
    float c = expf(l), s = safe_sqrtf(-expm1f(2.0f * l)), phi = 2.0f * PI_F * u.z;
    struct frame f = frame_from_normal(v3(-wo.x, -wo.y, wo.z));
    *wi = frame_to_world(&f, v3(s * cosf(phi), s * sinf(phi), c));
    return wi->z > 0.0f;
}

const struct brdf_model brdf_model_phong = {
    .name = "phong",
    .doc = "diffuse base and a cosine-power lobe about the mirror direction",
    .lobes = BRDF_REFLECT,
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_EXPONENT,
    .eval = phong_eval,
    .pdf = phong_pdf,
    .sample_glossy = phong_sample,
    .probabilities = brdf_mean_probabilities,
};
