// SPDX-License-Identifier: Apache-2.0
// Directional albedo: in closed form for delta and diffuse lobes. The glossy lobe has no closed
// form; its albedo is from a small table over outgoing directions that is made with the material
// or, if roughness is textured, from a few samples.
#include "base/sampling.h"
#include "brdf/brdf_models.h"

enum {
    ALBEDO_NODES = 33,    // along the radius of the parabolic map, centre to boundary
    ALBEDO_AZIMUTHS = 5,  // over a quadrant, if the model is anisotropic
    BUILD_POINTS = 256,
    MIXED_POINTS = 2048,  // of two lobes in one, of which 256 leave an error of 6 %
    LOOKUP_POINTS = 32
};

// The albedo of the glossy lobe of brdf_white, and of BRDF_THROUGH with `transmittance` 1.
struct brdf_glossy {
    struct brdf brdf;                // the tables are valid for a BRDF of the same shape
    const struct brdf_glossy *next;  // of the list of brdf_prepare
    int azimuths;                    // ALBEDO_AZIMUTHS, or 1 if isotropic
    struct nodes {
        rgb node[ALBEDO_AZIMUTHS][ALBEDO_NODES];
    } side[2][2];  // by lobe; for wo above and below
};

// The mean over the lobe's own samples from one fixed set of low-discrepancy points.
static rgb sample_mean(const struct brdf *b, vec3 wo, unsigned lobe, uint32_t points) {
    rgb sum = rgb_grey(0.0f);
    for (uint32_t i = 0; i < points; i++) {
        vec2 p = sample_sobol2(i, 1);
        struct brdf_sample s;
        if (brdf_sample_wi(b, wo, sample_sobol1(i, 2), p, lobe, BRDF_POWER, &s))
            sum = rgb_mad(sum, s.weight, 1.0f / (float)points);
    }
    return sum;
}

static void set_nodes(const struct brdf *white, int azimuths, unsigned lobe, bool below,
                      struct nodes *out) {
    const uint32_t points = brdf_is_factored(white) ? BUILD_POINTS : MIXED_POINTS;
    for (int j = 0; j < azimuths; j++)
        for (int i = 0; i < ALBEDO_NODES; i++) {
            // Just above the horizon, where some models are infinite.
            float r = minf((float)i / (ALBEDO_NODES - 1), 0.995f), scale = 1.0f / (1.0f + r * r);
            float phi = 0.5f * PI_F * (float)j / (ALBEDO_AZIMUTHS - 1);
            vec3 wo = v3(2.0f * r * scale * cosf(phi), 2.0f * r * scale * sinf(phi),
                         (below ? r * r - 1.0f : 1.0f - r * r) * scale);
            out->node[j][i] = sample_mean(white, wo, lobe, points);
        }
}

bool brdf_albedo_reuse(struct brdf *b, const struct brdf_glossy *made) {
    while (made &&
           !(brdf_same_shape(&made->brdf, b) && made->brdf.rough_texture == b->rough_texture))
        made = made->next;
    if (!made) return false;
    b->tables = made->brdf.tables;
    b->glossy = made;
    return true;
}

satin_status brdf_albedo_prepare(struct brdf *b, struct arena *arena,
                                 const struct brdf_glossy **made) {
    if (!(b->model->lobes & (BRDF_GLOSSY | BRDF_THROUGH))) return SATIN_OK;
    struct brdf_glossy *g = arena_alloc(arena, sizeof *g);
    if (!g) return SATIN_ERROR_MEMORY;
    struct brdf white = brdf_white(b);
    white.transmittance = rgb_grey(1.0f);
    g->brdf = *b;
    g->azimuths = brdf_isotropic(b) ? 1 : ALBEDO_AZIMUTHS;
    for (int below = 0; below < (brdf_transmits(b) ? 2 : 1); below++) {
        set_nodes(&white, g->azimuths, BRDF_GLOSSY, below, &g->side[0][below]);
        if (b->model->lobes & BRDF_THROUGH)
            set_nodes(&white, g->azimuths, BRDF_THROUGH, below, &g->side[1][below]);
    }
    b->glossy = g;
    if (!made) return SATIN_OK;
    g->next = *made;
    *made = g;
    return SATIN_OK;
}

static rgb lerp_nodes(const rgb *node, float x) {
    int i = x < (float)(ALBEDO_NODES - 2) ? (int)x : ALBEDO_NODES - 2;
    float t = x - (float)i;
    return rgb_mad(rgb_scale(node[i], 1.0f - t), node[i + 1], t);
}

// The albedo of BRDF_GLOSSY or BRDF_THROUGH.
static rgb glossy_albedo(const struct brdf *b, vec3 wo, unsigned lobe) {
    const struct brdf_glossy *g = b->glossy;
    if (!g || !brdf_same_shape(&g->brdf, b))
        return b->model->glossy_estimate ? b->model->glossy_estimate(b, wo, lobe)
                                         : sample_mean(b, wo, lobe, LOOKUP_POINTS);
    const struct nodes *nodes = &g->side[lobe == BRDF_THROUGH][wo.z < 0.0f];
    rgb factor = lobe == BRDF_THROUGH ? b->transmittance : brdf_glossy_factor(b);
    float x = sqrtf(wo.x * wo.x + wo.y * wo.y) / (1.0f + fabsf(wo.z)) * (float)(ALBEDO_NODES - 1);
    x = minf(x, (float)(ALBEDO_NODES - 1));
    if (g->azimuths == 1) return rgb_mul(lerp_nodes(nodes->node[0], x), factor);
    float y = atan2f(fabsf(wo.y), fabsf(wo.x)) * (2.0f / PI_F) * (float)(ALBEDO_AZIMUTHS - 1);
    int j = y < (float)(ALBEDO_AZIMUTHS - 2) ? (int)y : ALBEDO_AZIMUTHS - 2;
    rgb a = lerp_nodes(nodes->node[j], x), next = lerp_nodes(nodes->node[j + 1], x);
    a = rgb_mad(a, rgb_sub(next, a), y - (float)j);
    return rgb_mul(a, factor);
}

rgb brdf_albedo(const struct brdf *b, vec3 wo, unsigned lobes) {
    rgb sum = rgb_grey(0.0f);
    lobes &= brdf_lobes(b);
    if (lobes & BRDF_DELTA) {
        struct brdf_sample lobe[2];
        int n = brdf_delta(b, wo, BRDF_POWER, lobe);
        for (int i = 0; i < n; i++) sum = rgb_add(sum, lobe[i].weight);
    }
    if (!(wo.z > 0.0f) && !brdf_transmits(b)) return sum;
    if (lobes & BRDF_DIFFUSE)
        sum = rgb_add(sum, b->model->diffuse_albedo ? b->model->diffuse_albedo(b, wo) : b->diffuse);
    if (lobes & BRDF_GLOSSY) sum = rgb_add(sum, glossy_albedo(b, wo, BRDF_GLOSSY));
    return lobes & BRDF_THROUGH ? rgb_add(sum, glossy_albedo(b, wo, BRDF_THROUGH)) : sum;
}
