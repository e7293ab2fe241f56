// SPDX-License-Identifier: Apache-2.0
// Shading points: surface interactions with the BRDF and the frame in which it is evaluated.
#include "scene/scene.h"

void scene_shading_point_of(const struct satin_scene *scene, const struct material_side *side,
                            const struct interaction *s, vec3 d, struct shading_point *out) {
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

void scene_shading_point_make(const struct satin_scene *scene, const struct interaction *s, vec3 d,
                              struct shading_point *out) {
    scene_shading_point_of(scene, scene_draw_component(scene, s, v3_neg(d)), s, d, out);
}
