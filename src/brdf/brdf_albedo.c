// SPDX-License-Identifier: Apache-2.0
// Directional albedo: closed for delta and diffuse lobes; for the glossy lobe, which has no closed
// form, from a small table over outgoing directions that is made with the material. Where roughness
// is textured the table does not hold, and a few samples do instead.
#include "base/sampling.h"
#include "brdf/brdf_models.h"

enum {
    NODES = 33,    // along the radius of the parabolic map, centre to rim
    AZIMUTHS = 5,  // over a quadrant, if the model is anisotropic
    BUILD_POINTS = 256,
    LOOKUP_POINTS = 32
};

// Albedo of the glossy lobe with `specular` 1.
struct brdf_glossy {
    float alpha_u, alpha_v, exponent;  // the table holds for these
    int azimuths;                      // AZIMUTHS, or 1 if isotropic
    rgb node[AZIMUTHS][NODES];
};

// By the lobe's own sampler on one fixed set of well-spread points.
static rgb sample_mean(const struct brdf *b, vec3 wo, uint32_t points) {
    rgb sum = rgb_grey(0.0f);
    for (uint32_t i = 0; i < points; i++) {
        vec2 p = sample_sobol2(i, 1);
        struct brdf_sample s;
        if (brdf_sample(b, wo, 0.0f, p.x, p.y, BRDF_GLOSSY, BRDF_POWER, &s))
            sum = rgb_mad(sum, s.weight, 1.0f / (float)points);
    }
    return sum;
}

satin_status brdf_albedo_prepare(struct brdf *b, struct arena *arena) {
    if (!(b->model->lobes & BRDF_GLOSSY)) return SATIN_OK;
    struct brdf_glossy *g = arena_alloc(arena, sizeof *g);
    if (!g) return SATIN_ERROR_MEMORY;
    struct brdf white = *b;
    white.specular = rgb_grey(1.0f);
    g->alpha_u = b->alpha_u, g->alpha_v = b->alpha_v, g->exponent = b->exponent;
    g->azimuths = brdf_isotropic(b) ? 1 : AZIMUTHS;
    for (int j = 0; j < g->azimuths; j++)
        for (int i = 0; i < NODES; i++) {
            // Just above the rim, where some models are infinite.
            float r = minf((float)i / (NODES - 1), 0.995f), scale = 1.0f / (1.0f + r * r);
            float phi = 0.5f * PI_F * (float)j / (AZIMUTHS - 1);
            vec3 wo = v3(2.0f * r * scale * cosf(phi), 2.0f * r * scale * sinf(phi),
                         (1.0f - r * r) * scale);
            g->node[j][i] = sample_mean(&white, wo, BUILD_POINTS);
        }
    b->glossy = g;
    return SATIN_OK;
}

static rgb lerp_nodes(const rgb *node, float x) {
    int i = x < (float)(NODES - 2) ? (int)x : NODES - 2;
    float t = x - (float)i;
    return rgb_mad(rgb_scale(node[i], 1.0f - t), node[i + 1], t);
}

static rgb glossy_albedo(const struct brdf *b, vec3 wo) {
    const struct brdf_glossy *g = b->glossy;
    if (!g || g->alpha_u != b->alpha_u || g->alpha_v != b->alpha_v || g->exponent != b->exponent)
        return sample_mean(b, wo, LOOKUP_POINTS);
    float x = sqrtf(wo.x * wo.x + wo.y * wo.y) / (1.0f + wo.z) * (float)(NODES - 1);
    x = minf(x, (float)(NODES - 1));
    if (g->azimuths == 1) return rgb_mul(lerp_nodes(g->node[0], x), b->specular);
    float y = atan2f(fabsf(wo.y), fabsf(wo.x)) * (2.0f / PI_F) * (float)(AZIMUTHS - 1);
    int j = y < (float)(AZIMUTHS - 2) ? (int)y : AZIMUTHS - 2;
    rgb a = lerp_nodes(g->node[j], x), next = lerp_nodes(g->node[j + 1], x);
    a = rgb_mad(a, rgb_sub(next, a), y - (float)j);
    return rgb_mul(a, b->specular);
}

rgb brdf_albedo(const struct brdf *b, vec3 wo, unsigned lobes) {
    rgb sum = rgb_grey(0.0f);
    lobes &= brdf_lobes(b);
    if (lobes & BRDF_DELTA) {
        struct brdf_sample lobe[2];
        int n = brdf_delta(b, wo, BRDF_POWER, lobe);
        for (int i = 0; i < n; i++) sum = rgb_add(sum, lobe[i].weight);
    }
    if (!(wo.z > 0.0f)) return sum;
    if (lobes & BRDF_DIFFUSE)
        sum = rgb_add(sum, b->model->diffuse_albedo ? b->model->diffuse_albedo(b, wo) : b->diffuse);
    return lobes & BRDF_GLOSSY ? rgb_add(sum, glossy_albedo(b, wo)) : sum;
}
