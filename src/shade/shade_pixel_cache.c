// SPDX-License-Identifier: Apache-2.0
// The per-pixel cache: see shade_pixel_cache.h.
#include "shade/shade_pixel_cache.h"

// The cosine of the largest angle between equal directions: 3.6 degrees.
#define PIXEL_ALIKE 0.998f
#define ROUGH 0.02f  // largest relative difference of roughness
#define NEAR 2.0f    // pixels

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
