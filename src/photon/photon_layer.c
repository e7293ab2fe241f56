// SPDX-License-Identifier: Apache-2.0
// Surfaces that lie behind each other, such as the wall of a room and one outside behind it, or a
// floor and the ground beneath it. Their photons are near each other and face the same way.
#include <math.h>

#include "photon/photon_map.h"

// The least step between two points, over their distance, that may be one between surfaces. With
// .03 a closed room with a ground .02 below its floor was not black
// (docs/experiments/first-passes.md).
#define STEP_LEAST 0.01f

float photon_layer_step(vec3 p, vec3 n, vec3 q, vec3 m) {
    const vec3 d = v3_sub(q, p);
    const float over_p = v3_dot(d, n), over_q = -v3_dot(d, m);
    if ((over_p > 0.0f) == (over_q > 0.0f)) return 0.0f;  // the surface is curved
    const float step = fminf(fabsf(over_p), fabsf(over_q));
    return step * step > sqrf(STEP_LEAST) * v3_dot(d, d) ? copysignf(step, over_p) : 0.0f;
}

// Whether a surface is above the lower one of p and q, up to a height over the plane of the other.
static bool is_under_other(const struct satin_scene *scene, vec3 p, vec3 n, vec3 q, vec3 m,
                           float height) {
    const float step = photon_layer_step(p, n, q, m);
    if (step == 0.0f) return false;
    if (step < 0.0f) return is_under_other(scene, q, m, p, n, height);
    struct ray ray = scene_spawn(scene, p, n, n);
    ray.tfar = 1.01f * v3_dot(v3_sub(q, p), m) / v3_dot(n, m) + height;
    return scene_occluded(scene, &ray);
}

void photon_disc_drop_hidden(const struct satin_scene *scene, int *row, float *distance2,
                             struct photon_disc *disc) {
    const float height = disc->corrected ? disc->area.height : 0.0f;
    int counted = 0;
    for (int i = 0; i < disc->count; i++) {
        const int at = row[i];
        const float d2 = distance2[i];
        if (at < 0 || !(d2 < disc->r2)) continue;
        const vec3 q = photon_position(disc->map, (size_t)at),
                   m = photon_unpack(disc->map->photon[at].n);
        if (!photon_is_on_surface(disc->n, m, v3_dot(v3_sub(q, disc->p), disc->n), disc->r2) ||
            is_under_other(scene, disc->p, disc->n, q, m, height) ||
            (disc->corrected && photon_area_hides(scene, &disc->area, disc->p, q)))
            continue;
        row[i] = row[counted];
        distance2[i] = distance2[counted];
        row[counted] = at;
        distance2[counted++] = d2;
    }
    disc->count = counted;
}
