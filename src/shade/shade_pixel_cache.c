// SPDX-License-Identifier: Apache-2.0
// The per-pixel cache: see shade_pixel_cache.h.
#include "shade/shade_pixel_cache.h"

// The cosine of the largest angle between equal directions: 3.6 degrees.
#define PIXEL_ALIKE 0.998f
#define ROUGH 0.02f  // largest relative difference of roughness
#define NEAR 2.0f    // pixels

// Across a pixel of a curved surface a glossy lobe points to other things. With one position in
// each pass of the image this was half of the error of cornell-metal at production, which no number
// of samples lowered (docs/experiments/direct-light.md).
enum { POSITIONS_MOST = 16 };
#define MEAN_ERROR_MOST 0.005f  // largest standard error, relative to the mean

struct shade_pixel_value *shade_pixel_cache_find(struct shade_pixel_cache *cache,
                                                 const struct shading_point *p, float pixel) {
    vec3 wo = frame_to_world(&p->frame, p->wo_l);
    for (int i = 0; i < cache->count; i++) {
        struct shade_pixel_value *e = &cache->value[i];
        if (e->side == p->side && fabsf(e->alpha - p->brdf.alpha_u) < ROUGH * e->alpha &&
            fabsf(e->exponent - p->brdf.exponent) <= 2.0f * ROUGH * e->exponent &&
            v3_dot(e->n, p->frame.n) > PIXEL_ALIKE && v3_dot(e->wo, wo) > PIXEL_ALIKE &&
            v3_dist2(e->p, p->interaction.p) < sqrf(NEAR * pixel))
            return e;
    }
    struct shade_pixel_value *e = &cache->value[cache->next];
    cache->next = (cache->next + 1) % SHADE_PIXEL_VALUES;
    if (cache->count < SHADE_PIXEL_VALUES) cache->count++;
    *e = (struct shade_pixel_value){.p = p->interaction.p,
                                    .n = p->frame.n,
                                    .wo = wo,
                                    .side = p->side,
                                    .alpha = p->brdf.alpha_u,
                                    .exponent = p->brdf.exponent};
    return e;
}

static bool is_certain(rgb mean, float squares, int count) {
    const float Y2 = sqrf(rgb_luminance(mean));
    return squares - Y2 <= sqrf(MEAN_ERROR_MOST) * Y2 * (float)(count - 1);
}

bool shade_pixel_light_wanted(const struct shade_pixel_value *value, enum cache_kind kind) {
    const struct shade_pixel_light *light = &value->light[kind];
    if (light->count == 0) return true;
    if (kind != CACHE_RADIANCE || light->count >= POSITIONS_MOST) return false;
    return light->count == 1 || !is_certain(light->E, light->E2, light->count) ||
           !is_certain(light->glossy, light->glossy2, light->count);
}

static rgb mean_with(rgb mean, rgb next, float weight) {
    return rgb_add(mean, rgb_scale(rgb_sub(next, mean), weight));
}

void shade_pixel_light_add(struct shade_pixel_light *light, struct cache_used used, rgb glossy,
                           rgb E) {
    const float weight = 1.0f / (float)++light->count;
    light->used = used;
    light->E = mean_with(light->E, E, weight);
    light->E2 += weight * (sqrf(rgb_luminance(E)) - light->E2);
    light->glossy = mean_with(light->glossy, glossy, weight);
    light->glossy2 += weight * (sqrf(rgb_luminance(glossy)) - light->glossy2);
}
