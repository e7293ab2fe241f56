// SPDX-License-Identifier: Apache-2.0
// From a surface point to the BRDF there: which side is seen, textures looked up, the frame set.
// Sides are told by the shading normal, as the BRDF's own cosines are.
#include "scene/scene.h"

// Replaces the constants of `b` that are textured. Numbers take a texture's luminance, within what
// the models can stand.
static void look_up(const struct material_side *side, vec2 uv, struct brdf *b) {
    const struct texture *const *slot = side->slot;
    if (slot[BRDF_SLOT_DIFFUSE]) b->diffuse = texture_eval(slot[BRDF_SLOT_DIFFUSE], uv);
    if (slot[BRDF_SLOT_SPECULAR]) b->specular = texture_eval(slot[BRDF_SLOT_SPECULAR], uv);
    if (slot[BRDF_SLOT_TRANSMITTANCE])
        b->transmittance = texture_eval(slot[BRDF_SLOT_TRANSMITTANCE], uv);
    float *number[] = {&b->alpha_u, &b->alpha_v, &b->exponent};
    for (int i = 0; i < 3; i++) {
        const struct texture *texture = slot[BRDF_SLOT_ALPHA_U + i];
        if (texture) *number[i] = clampf(rgb_luminance(texture_eval(texture, uv)), 0.0f, 1e6f);
    }
}

bool scene_brdf(const struct satin_scene *scene, const struct surfel *s, vec3 wo, struct brdf *brdf,
                struct frame *frame) {
    const struct material *m = &scene->material[s->material];
    bool behind = v3_dot(wo, s->frame.n) < 0.0f, back = behind && m->two_sided;
    const struct material_side *side = back ? &m->back : &m->front;
    if (behind && !back && !side->base.model->transmits) return false;
    *brdf = side->base;
    look_up(side, s->uv, brdf);
    *frame = back ? frame_flip(s->frame) : s->frame;
    return brdf_lobes(brdf) != 0;
}
