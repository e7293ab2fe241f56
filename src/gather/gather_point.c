// SPDX-License-Identifier: Apache-2.0
// Surface points prepared for shading, and the constants of a render.
#include "gather/gather.h"

// A light is wide if its area is more than this fraction of that of the scene's bounding sphere.
// Its solid angle is then often large, and light sampling alone is noisy close to it.
static const float WIDE_AREA = 0.02f;

struct gather gather_make(const struct satin_scene *scene, const satin_options *options,
                          const struct photon_maps *maps) {
    struct gather g = {.scene = scene, .options = options, .maps = maps};
    g.clusters = photon_clusters(maps);
    g.lookup_max = maps ? photon_lookup_max(maps) : INFINITY;
    float sphere = 4.0f * PI_F * sqrf(scene->radius);
    g.wide_lights = scene->environment >= 0;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const struct light *light = &scene->light[i];
        if (light->kind == LIGHT_AREA && scene->shape[light->shape].area > WIDE_AREA * sphere)
            g.wide_lights = true;
    }
    return g;
}

void gather_point_of(const struct satin_scene *scene, const struct material_side *side,
                     const struct interaction *s, vec3 d, struct gather_point *out) {
    vec3 wo = v3_neg(d);
    out->interaction = *s;
    out->ng = v3_dot(s->ng, wo) < 0.0f ? v3_neg(s->ng) : s->ng;
    out->side = side;
    out->base = scene_component_frame(scene, side, s, wo);
    if (scene_component_brdf(scene, side, s, wo, &out->brdf, &out->frame)) {
        out->lobes = brdf_lobes(&out->brdf);
    } else {
        out->lobes = 0;
        out->frame = s->frame;
    }
    out->wo_l = frame_to_local(&out->frame, wo);
}

void gather_point_make(const struct satin_scene *scene, const struct interaction *s, vec3 d,
                       struct gather_point *out) {
    gather_point_of(scene, scene_component(scene, s, v3_neg(d)), s, d, out);
}
