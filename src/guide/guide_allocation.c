// SPDX-License-Identifier: Apache-2.0
// How many of the photons each light gets. Allocated by power all photons weigh alike. But power
// may go where nothing of it is visible, as that of the sky around a closed room, and what is left
// for the lamp inside is too few to represent its light. So one half is allocated by power, the
// other by what a few paths from the eye find: they go on as light's paths to the gather rays' hits
// would, backwards, and sample the lights where they go. The first half serves light that comes in
// ways that they have missed.
#include "guide/guide.h"

#include <limits.h>

#include "base/sampling.h"

enum { BOUNCES = 3 };  // of a path: behind the first one is what gather rays ask photons for

// Irradiance that each light brings to the paths' vertices.
struct light_tally {
    const struct satin_scene *scene;
    double light[GUIDE_ALLOCATION_LIGHTS];
};

// What comes from one light at s, chosen by chance.
static void add_direct(struct light_tally *tally, const struct interaction *s, vec3 n, float T,
                       struct rng *rng) {
    const struct satin_scene *scene = tally->scene;
    const float u_choose = rng_float(rng), u = rng_float(rng), v = rng_float(rng);
    float choice;
    struct light_sample sample;
    const uint32_t light = light_choose(scene, s->p, LIGHT_ALL_VISIBLE, u_choose, &choice);
    if (!light_sample(scene, light, s->p, u, v, &sample)) return;
    const float cosine = v3_dot(sample.wi, n);
    if (!(cosine > 0.0f)) return;
    if (!light_arrives(scene, s->p, s->ng, INT_MAX, &sample)) return;
    const float E = T * cosine * rgb_luminance(sample.L) / (sample.pdf_w * choice);
    if (isfinite(E)) tally->light[light] += (double)E;
}

// A light that the last ray has met behind ideal specular surfaces that are no panes, where no
// sample finds it.
static void add_met(struct light_tally *tally, const struct ray *ray, const struct interaction *hit,
                    float T) {
    const struct satin_scene *scene = tally->scene;
    const int light = hit ? hit->light : scene->environment;
    if (light < 0) return;
    const float E = T * PI_F * rgb_luminance(light_met(scene, hit, ray->d));
    if (isfinite(E)) tally->light[light] += (double)E;
}

static void walk_path(struct light_tally *tally, struct interaction s, vec3 n, struct rng *rng) {
    const struct satin_scene *scene = tally->scene;
    float T = 1.0f;
    for (int i = 0; i < BOUNCES; i++) {
        const struct frame frame = frame_from_normal(n);
        const float u = rng_float(rng), v = rng_float(rng);
        const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(u, v));
        struct ray ray = scene_spawn(scene, s.p, s.ng, d);
        struct light_chain chain;
        const bool found = guide_view_follow(scene, &ray, rng, &s, &n, &chain);
        if (!light_chain_straight(&chain, ray.d)) add_met(tally, &ray, found ? &s : NULL, T);
        if (!found) return;
        add_direct(tally, &s, n, T, rng);
        struct brdf b;
        struct frame local;
        const vec3 wo = v3_neg(ray.d);
        if (!scene_brdf(scene, &s, wo, &b, &local)) return;
        T *= rgb_luminance(brdf_albedo(&b, frame_to_local(&local, wo), BRDF_SMOOTH));
    }
}

void guide_allocation_make(const struct satin_scene *scene, uint64_t seed,
                           struct guide_allocation *out) {
    struct light_tally tally = {.scene = scene};
    double sum = 0.0;
    out->by_power = true;
    // Among more lights than this, chance would allocate.
    if (scene->light_count < 2 || scene->light_count > GUIDE_ALLOCATION_LIGHTS) return;
    for (uint32_t i = 0; i < GUIDE_VIEW_PATHS; i++) {
        struct rng rng = rng_make(seed, RNG_ALLOCATION, i);
        struct interaction s;
        vec3 n;
        if (guide_view_eye(scene, i, &rng, &s, &n)) walk_path(&tally, s, n, &rng);
    }
    for (uint32_t i = 0; i < scene->light_count; i++) sum += tally.light[i];
    if (!(sum > 0.0)) return;
    out->by_power = false;
    for (uint32_t i = 0; i < scene->light_count; i++)
        out->fraction[i] = 0.5f * (scene->light_cdf[i + 1] - scene->light_cdf[i]) +
                           0.5f * (float)(tally.light[i] / sum);
}
