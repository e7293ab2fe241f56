// SPDX-License-Identifier: Apache-2.0
// Generalised cosine lobes [Lafortune et al. 1997]: f = diffuse / pi + sum of colour * c^n with c =
// cx xo xi + cy yo yi + cz zo zi where that is positive. With cx = cy = -1 and cz = 1 a lobe is an
// unnormalised Phong lobe. It is anisotropic if cx and cy differ, and off-specular if cz is larger
// than the others.
#include "base/frame.h"
#include "brdf/brdf_models.h"

struct lobes {
    int count;
    struct brdf_cosine_lobe lobe[BRDF_COSINE_LOBES_MAX];
};

satin_status brdf_lafortune_set(struct brdf *b, struct arena *arena,
                                const struct brdf_cosine_lobe *lobe, int count) {
    struct lobes *l = arena_alloc(arena, sizeof *l);
    if (!l) return SATIN_ERROR_MEMORY;
    l->count = count;
    b->isotropic = true;
    for (int i = 0; i < count; i++) {
        l->lobe[i] = lobe[i];
        if (lobe[i].c.x != lobe[i].c.y) b->isotropic = false;
    }
    b->tables = l;
    return SATIN_OK;
}

// The axis of a lobe, not a unit vector: c is its dot product with wi.
static vec3 axis_of(const struct brdf_cosine_lobe *l, vec3 wo) {
    return v3(l->c.x * wo.x, l->c.y * wo.y, l->c.z * wo.z);
}

static void lafortune_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    const struct lobes *l = b->tables;
    *diffuse = rgb_scale(b->diffuse, 1.0f / PI_F);
    *glossy = rgb_grey(0.0f);
    for (int i = 0; i < l->count; i++) {
        float c = v3_dot(axis_of(&l->lobe[i], wo), wi);
        if (c > 0.0f) *glossy = rgb_mad(*glossy, l->lobe[i].color, powf(c, l->lobe[i].exponent));
    }
    *glossy = rgb_mul(*glossy, b->specular);
}

// Probabilities by the lobes' integrals over the sphere. False if none reflects.
static bool lobe_probabilities(const struct lobes *l, vec3 wo,
                               float probability[BRDF_COSINE_LOBES_MAX]) {
    float sum = 0.0f;
    for (int i = 0; i < l->count; i++) {
        float n = l->lobe[i].exponent, length = v3_len(axis_of(&l->lobe[i], wo));
        probability[i] = rgb_mean(l->lobe[i].color) * powf(length, n) / (n + 1.0f);
        sum += probability[i];
    }
    for (int i = 0; i < l->count; i++) probability[i] /= sum;
    return sum > 0.0f && isfinite(sum);
}

static void lafortune_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                          float *glossy) {
    (void)lobes;
    const struct lobes *l = b->tables;
    float probability[BRDF_COSINE_LOBES_MAX];
    *diffuse = wi.z * (1.0f / PI_F);
    *glossy = 0.0f;
    if (!lobe_probabilities(l, wo, probability)) return;
    for (int i = 0; i < l->count; i++) {
        vec3 axis = axis_of(&l->lobe[i], wo);
        float n = l->lobe[i].exponent, c = v3_dot(axis, wi);
        if (!(c > 0.0f) || probability[i] == 0.0f) continue;
        *glossy +=
            probability[i] * (n + 1.0f) * (0.5f / PI_F) * powf(minf(c / v3_len(axis), 1.0f), n);
    }
}

static bool lafortune_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    (void)lobes;
    const struct lobes *l = b->tables;
    float probability[BRDF_COSINE_LOBES_MAX], x = u.x;
    if (!lobe_probabilities(l, wo, probability)) return false;
    int i = 0;
    for (; i < l->count - 1 && x >= probability[i]; i++) x -= probability[i];
    vec3 axis = axis_of(&l->lobe[i], wo);
    if (!(v3_len2(axis) > 0.0f)) return false;
    float t = logf(maxf(1.0f - u.y, 0x1p-25f)) / (l->lobe[i].exponent + 1.0f);
    float c = expf(t), s = safe_sqrtf(-expm1f(2.0f * t)), phi = 2.0f * PI_F * u.z;
    struct frame f = frame_from_normal(v3_unit(axis));
    *wi = frame_to_world(&f, v3(s * cosf(phi), s * sinf(phi), c));
    return wi->z > 0.0f;
}

static void lafortune_probabilities(const struct brdf *b, vec3 wo, float *diffuse, float *glossy,
                                    float *delta) {
    (void)wo;
    *delta = 0.0f;
    *diffuse = rgb_mean(b->diffuse);
    *glossy = maxf(1.0f - *diffuse, 0.1f);
}

const struct brdf_model brdf_model_lafortune = {
    .name = "lafortune",
    .doc = "diffuse base and generalised cosine lobes",
    .lobes = BRDF_REFLECT,
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_SPECULAR,
    .data = true,
    .eval = lafortune_eval,
    .pdf = lafortune_pdf,
    .sample_glossy = lafortune_sample,
    .probabilities = lafortune_probabilities,
};
