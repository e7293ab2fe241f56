// SPDX-License-Identifier: Apache-2.0
// The constants of gathering in a render.
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
    g.wide_lights = g.rays_find_lights = scene->environment >= 0;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const struct light *light = &scene->light[i];
        if (light->kind == LIGHT_AREA) g.rays_find_lights = true;
        if (light->kind == LIGHT_AREA && scene->shape[light->shape].area > WIDE_AREA * sphere)
            g.wide_lights = true;
    }
    return g;
}
