// SPDX-License-Identifier: Apache-2.0
// Surfaces with holes; scene_opacity.h describes them.
#include "scene/scene_opacity.h"

#include <string.h>

#include "base/rng.h"

float scene_opacity_weight(const struct material_side *side, const struct texture_lookup *at) {
    if (!side->blend) return side->weight;
    struct texture_lookup point = *at;
    point.width = 0.0f;
    return clampf(scene_texture_number(side->blend, &point), 0.0f, 1.0f);
}

float scene_opacity_side(const struct material_side *side, const struct texture_lookup *at) {
    if (!side->holes) return 1.0f;
    if (!side->component[0]) return 0.0f;
    float second = scene_opacity_weight(side, at);
    return (1.0f - second) * scene_opacity_side(side->component[0], at) +
           second * scene_opacity_side(side->component[1], at);
}

const struct material *scene_opacity_of(const struct satin_scene *scene,
                                        const struct shape *shape) {
    const struct material *m = &scene->material[shape->material];
    return shape->light < 0 && m->front.holes ? m : NULL;
}

float scene_opacity_material(const struct material *m, const struct texture_lookup *at) {
    return scene_opacity_side(&m->front, at);
}

bool scene_opacity_stops(const struct material *m, const struct texture_lookup *at,
                         const struct ray *ray, uint32_t salt, bool whole) {
    float a = scene_opacity_material(m, at);
    if (whole || a <= 0.0f || a >= 1.0f) return a > 0.0f;
    const float f[6] = {ray->o.x, ray->o.y, ray->o.z, ray->d.x, ray->d.y, ray->d.z};
    uint32_t bits[6];
    uint64_t key = rng_mix(salt + 0x2545f4914f6cdd1dull);
    memcpy(bits, f, sizeof bits);
    for (int i = 0; i < 6; i += 2) key = rng_mix(key ^ ((uint64_t)bits[i] << 32 | bits[i + 1]));
    return (float)(key >> 40) * 0x1p-24f < a;
}
