// SPDX-License-Identifier: Apache-2.0
// Allocates photon paths to the lights. Allocated by power alone, all photons would have the same
// power. But much of the power may be invisible, such as that of the sky around a closed room, and
// too few photons would be left for a lamp inside. So one half is allocated by power, and the other
// half by what a few paths from the eye find: they continue as light paths to the hits of gather
// rays would, in reverse, and sample the lights at their vertices. The first half represents light
// that these paths have missed.
#include "guide/guide.h"

#include <limits.h>

#include "base/sampling.h"

// Bounces of a path; gather rays read photons from the second vertex on.
enum { ALLOCATION_BOUNCES = 3 };

// The irradiance from the lights at the vertices of one path, in their order.
struct path_tally {
    int count;
    struct {
        uint32_t light;
        float E;
    } found[2 * ALLOCATION_BOUNCES];  // at each vertex one light that was hit and one that was
                                      // sampled
};

struct tally_paths {
    const struct satin_scene *scene;
    uint64_t seed;
    struct path_tally path[GUIDE_SEEN_PATHS_MAX];
};

static void add_arrival(struct path_tally *tally, uint32_t light, float E) {
    if (!isfinite(E)) return;
    tally->found[tally->count].light = light;
    tally->found[tally->count++].E = E;
}

// Adds the irradiance at s from one light, chosen at random.
static void add_direct(struct path_tally *tally, const struct satin_scene *scene,
                       const struct interaction *s, vec3 n, float T, struct rng *rng) {
    float u = rng_float(rng), choice;
    const float v = rng_float(rng);
    struct light_sample sample;
    const uint32_t light = light_choose(scene, s->p, LIGHT_ALL_VISIBLE, &u, &choice);
    if (!light_sample_wi(scene, light, s->p, u, v, &sample)) return;
    const float cosine = v3_dot(sample.wi, n);
    if (!(cosine > 0.0f)) return;
    if (!light_arrives(scene, s->p, s->ng, INT_MAX, &sample)) return;
    add_arrival(tally, light, T * cosine * rgb_luminance(sample.L) / (sample.pdf_w * choice));
}

// Adds a light that the last ray has hit behind ideal specular surfaces other than panes, where
// light samples cannot find it.
static void add_met(struct path_tally *tally, const struct satin_scene *scene,
                    const struct ray *ray, const struct interaction *hit, float T) {
    const int light = hit ? hit->light : scene->environment;
    if (light < 0) return;
    add_arrival(tally, (uint32_t)light, T * PI_F * rgb_luminance(light_at_hit(scene, hit, ray->d)));
}

static void walk_path(struct path_tally *tally, const struct satin_scene *scene,
                      struct interaction s, vec3 n, struct rng *rng) {
    float T = 1.0f;
    for (int i = 0; i < ALLOCATION_BOUNCES; i++) {
        const struct frame frame = frame_from_normal(n);
        const float u = rng_float(rng), v = rng_float(rng);
        const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(u, v));
        struct ray ray = scene_spawn(scene, s.p, s.ng, d);
        struct light_chain chain;
        const bool found = guide_seen_follow(scene, &ray, rng, &s, &n, &chain);
        const struct interaction *end = found ? &s : NULL;
        struct light_connection to;
        if (!light_chain_direct(&chain, scene, ray.d, end, &to))
            add_met(tally, scene, &ray, end, T);
        if (!found) return;
        add_direct(tally, scene, &s, n, T, rng);
        struct brdf b;
        struct frame local;
        const vec3 wo = v3_neg(ray.d);
        if (!scene_brdf(scene, &s, wo, &b, &local)) return;
        T *= rgb_luminance(brdf_albedo(&b, frame_to_local(&local, wo), BRDF_SMOOTH));
    }
}

static void trace_allocation(void *ctx, size_t begin, size_t end, int worker) {
    struct tally_paths *paths = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(paths->seed, RNG_ALLOCATION, i);
        struct interaction s;
        vec3 n;
        if (guide_seen_eye(paths->scene, (uint32_t)i, &rng, &s, &n))
            walk_path(&paths->path[i], paths->scene, s, n, &rng);
    }
}

void guide_allocation_make(const struct satin_scene *scene, uint64_t seed, int paths,
                           struct parallel *pool, struct guide_allocation *out) {
    struct tally_paths traced = {.scene = scene, .seed = seed};
    double light[GUIDE_ALLOCATION_LIGHTS] = {0.0}, sum = 0.0;
    out->by_power = true;
    // With more lights than this the allocation would be mostly noise.
    if (scene->light_count < 2 || scene->light_count > GUIDE_ALLOCATION_LIGHTS) return;
    parallel_for_all(pool, (size_t)paths, GUIDE_SEEN_CHUNK, trace_allocation, &traced);
    for (int i = 0; i < paths; i++)
        for (int k = 0; k < traced.path[i].count; k++)
            light[traced.path[i].found[k].light] += (double)traced.path[i].found[k].E;
    for (uint32_t i = 0; i < scene->light_count; i++) sum += light[i];
    if (!(sum > 0.0)) return;
    out->by_power = false;
    for (uint32_t i = 0; i < scene->light_count; i++)
        out->fraction[i] =
            0.5f * (scene->light_cdf[i + 1] - scene->light_cdf[i]) + 0.5f * (float)(light[i] / sum);
}
