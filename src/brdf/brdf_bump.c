// SPDX-License-Identifier: Apache-2.0
// Facets of bump and normal maps. If a map has rotated the frame, directions must be on the same
// side of the rotated and of the true surface, and light at grazing angles to the true surface is
// shadowed by the slopes of the map [Estevez et al. 2019].
#include "base/sampling.h"
#include "brdf/brdf_models.h"

float brdf_bump_toward(const struct brdf *b, vec3 w, vec3 light) {
    float left = 1.0f;
    for (int i = 0; i < BRDF_BUMPS_MAX && brdf_is_rotated(b, i); i++) {
        if (!(v3_dot(b->base[i], w) * w.z > 0.0f)) return 0.0f;
        float c = v3_dot(b->base[i], light), c2 = c * c;
        if (b->bump[i] == 0.0f || !(c2 > 0.0f)) continue;
        left *= 2.0f / (1.0f + sqrtf(1.0f + b->bump[i] * maxf(1.0f - c2, 0.0f) / c2));
    }
    return left;
}

enum { MEAN_RINGS = 8, MEAN_SECTORS = 16 };

// The mean of two maps, by directions of equal irradiance of the facet: where both tilt, light
// between the two facets is hidden too.
static float mean_of_both(const struct brdf *b) {
    float left = 0.0f, all = 0.0f;
    for (int i = 0; i < MEAN_RINGS; i++)
        for (int k = 0; k < MEAN_SECTORS; k++) {
            const float u = ((float)i + 0.5f) / MEAN_RINGS, v = ((float)k + 0.5f) / MEAN_SECTORS;
            const vec3 w = sample_cosine_hemisphere(u, v);
            if (!(v3_dot(b->base[0], w) > 0.0f)) continue;
            left += brdf_bump_toward(b, w, w);
            all += 1.0f;
        }
    return all > 0.0f ? left / all : 0.0f;
}

// That of one map is a fit, accurate to .3 %, of the mean over uniform light above the surface that
// falls on a facet whose tilt goes with the alpha of its map. Alpha has its limit at a cosine of
// 1/3.
float brdf_bump_diffuse(const struct brdf *b) {
    if (!brdf_has_bump(b)) return 1.0f;
    if (brdf_is_rotated(b, 1)) return mean_of_both(b);
    const float a = sqrtf(b->bump[0]);
    float mean = 1.0f - b->bump[0] / (0.4388f + a * (1.1329f + a * 1.0467f));
    if (b->bump[0] == 1.0f) mean -= 0.21f * maxf(1.0f / 3.0f - fabsf(b->base[0].z), 0.0f);
    return mean;
}

float brdf_bump_glossy(const struct brdf *b, vec3 wo) {
    vec3 mirror = v3(-wo.x, -wo.y, wo.z);
    return brdf_has_bump(b) ? brdf_bump_toward(b, mirror, mirror) : 1.0f;
}

float brdf_bump_shadowing(const struct brdf *b, vec3 wi) {
    return brdf_has_bump(b) ? brdf_bump_toward(b, wi, wi) : 1.0f;
}
