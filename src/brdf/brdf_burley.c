// SPDX-License-Identifier: Apache-2.0
// The diffuse lobe of the principled models, see brdf_burley.h. With F = (1 - cos)^5 at both
// directions, c = cos^2 of half the angle between them, r the roughness and R = 2 r c:
//   diffuse (1 - Fo/2) (1 - Fi/2), retroreflection R (Fo + Fi + Fo Fi (R - 1)),
//   flattened 1.25 (S (1 / (cos_o + cos_i) - 1/2) + 1/2), S = (1 + (r c - 1) Fo) (1 + (r c - 1)
//   Fi).
// All are polynomials in r whose coefficients integrate to functions of cos_o alone.
#include "brdf/brdf_burley.h"

#include "brdf/brdf_models.h"
#include "brdf/brdf_quadrature.h"

enum { BURLEY_SIZE = 33, AZIMUTHS = 32, NODES = 24 };

// Cosine-weighted means over the hemisphere, for cosines 0 to 1 at equal distances. They are named
// after their integrands: c, c^2, F = Fi, G = 1 - Fi, w = 1 / (cos_o + cos_i) - 1/2, and the
// Schlick weight of the sheen.
struct burley {
    float c[BURLEY_SIZE], cF[BURLEY_SIZE], c2F[BURLEY_SIZE], wG[BURLEY_SIZE], wcF[BURLEY_SIZE],
        wcG[BURLEY_SIZE], wc2F[BURLEY_SIZE], sheen[BURLEY_SIZE];
};

satin_status brdf_burley_prepare(struct brdf *b, struct arena *arena) {
    struct burley *t = arena_alloc(arena, sizeof *t);
    if (!t) return SATIN_ERROR_MEMORY;
    struct quadrature rule;
    brdf_quadrature_gauss(&rule, NODES);
    for (int i = 0; i < BURLEY_SIZE; i++) {
        float mu = maxf((float)i / (BURLEY_SIZE - 1), 1e-3f), s = safe_sqrtf(1.0f - mu * mu);
        double sum[8] = {0};
        for (int j = 0; j < NODES; j++)
            for (int k = 0; k < AZIMUTHS; k++) {
                double x = rule.x[j], phi = M_PI * (k + 0.5) / AZIMUTHS;
                double weight = rule.weight[j] * 2.0 * x / AZIMUTHS;
                double c = 0.5 * (1.0 + mu * x + s * sqrt(1.0 - x * x) * cos(phi));
                double F = (double)brdf_burley_weight((float)x), w = 1.0 / (mu + x) - 0.5;
                const double value[8] = {c,
                                         c * F,
                                         c * c * F,
                                         w * (1.0 - F),
                                         w * c * F,
                                         w * c * (1.0 - F),
                                         w * c * c * F,
                                         (double)brdf_burley_weight((float)sqrt(c))};
                for (int n = 0; n < 8; n++) sum[n] += weight * value[n];
            }
        t->c[i] = (float)sum[0], t->cF[i] = (float)sum[1], t->c2F[i] = (float)sum[2];
        t->wG[i] = (float)sum[3], t->wcF[i] = (float)sum[4], t->wcG[i] = (float)sum[5];
        t->wc2F[i] = (float)sum[6], t->sheen[i] = (float)sum[7];
    }
    b->tables = t;
    return SATIN_OK;
}

static rgb sheen_color(const struct brdf *b) {
    rgb tint = rgb_scale(brdf_burley_tint(b), b->sheen_tint);
    return rgb_scale(rgb_add(tint, rgb_grey(1.0f - b->sheen_tint)), b->sheen);
}

rgb brdf_burley_diffuse(const struct brdf *b, vec3 wo, vec3 wi, float base, float sheen) {
    float Fo = brdf_burley_weight(wo.z), Fi = brdf_burley_weight(wi.z);
    float c = minf(0.25f * v3_len2(v3_add(wo, wi)), 1.0f), R = 2.0f * b->alpha_u * c;
    float f = (1.0f - 0.5f * Fo) * (1.0f - 0.5f * Fi) + R * (Fo + Fi + Fo * Fi * (R - 1.0f));
    if (b->flatness > 0.0f) {
        float m = 0.5f * R - 1.0f, S = (1.0f + m * Fo) * (1.0f + m * Fi);
        float flat = 1.25f * (S * (1.0f / (wo.z + wi.z) - 0.5f) + 0.5f);
        f = lerpf(f, flat, b->flatness);
    }
    rgb value = rgb_scale(b->diffuse, base * f * (1.0f / PI_F));
    if (b->sheen == 0.0f) return value;
    return rgb_mad(value, sheen_color(b), sheen * brdf_burley_weight(sqrtf(c)));
}

rgb brdf_burley_diffuse_albedo(const struct brdf *b, float cosine, float base, float sheen) {
    const struct burley *t = b->tables;
    float x = cosine * (float)(BURLEY_SIZE - 1), r = b->alpha_u, F = brdf_burley_weight(cosine),
          G = 1.0f - F;
    int i = x < (float)(BURLEY_SIZE - 2) ? (int)x : BURLEY_SIZE - 2;
    x -= (float)i;
#define ROW_AT(name) lerpf(t->name[i], t->name[i + 1], x)
    // The mean of 1 - Fi / 2 is 41 / 42.
    float f = (1.0f - 0.5f * F) * (41.0f / 42.0f) +
              2.0f * r * (F * ROW_AT(c) + G * ROW_AT(cF) + 2.0f * r * F * ROW_AT(c2F));
    if (b->flatness > 0.0f) {
        float S = G * ROW_AT(wG) + r * (G * ROW_AT(wcF) + F * ROW_AT(wcG) + r * F * ROW_AT(wc2F));
        f = lerpf(f, 1.25f * (S + 0.5f), b->flatness);
    }
    rgb albedo = rgb_scale(b->diffuse, base * f);
    return rgb_mad(albedo, sheen_color(b), sheen * PI_F * ROW_AT(sheen));
#undef ROW_AT
}
