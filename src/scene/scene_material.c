// SPDX-License-Identifier: Apache-2.0
// From a surface point to the BRDF there: which side is seen, textures looked up, the frame set.
// Sides are told by the shading normal, as the BRDF's own cosines are.
#include "scene/scene.h"

// Replaces the constants of `b` that are textured. Numbers take a texture's luminance, within what
// the models can stand.
static void look_up(const struct material_side *side, vec2 uv, struct brdf *b) {
    const struct texture *const *slot = side->slot;
    for (enum brdf_slot i = 0; i < BRDF_SLOT_COUNT; i++) {
        if (!slot[i]) continue;
        rgb value = texture_eval(slot[i], uv);
        if (i < BRDF_SLOT_NUMBERS)
            *brdf_color(b, i) = value;
        else
            *brdf_number(b, i) = clampf(rgb_luminance(value), 0.0f, 1e6f);
    }
}

bool scene_brdf(const struct satin_scene *scene, const struct surfel *s, vec3 wo, struct brdf *brdf,
                struct frame *frame) {
    const struct material *m = &scene->material[s->material];
    bool behind = v3_dot(wo, s->frame.n) < 0.0f, back = behind && m->two_sided;
    const struct material_side *side = back ? &m->back : &m->front;
    if (behind && !back && !brdf_transmits(&side->base)) return false;
    *brdf = side->base;
    look_up(side, s->uv, brdf);
    *frame = back ? frame_flip(s->frame) : s->frame;
    return brdf_lobes(brdf) != 0;
}
