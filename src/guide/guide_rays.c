// SPDX-License-Identifier: Apache-2.0
// Rays of a hemisphere to photon clusters. Its stratified rays hit a small bright cluster only by
// chance, so additional rays are drawn to each cluster that is visible. All rays are one estimate
// by the balance heuristic [Veach and Guibas 1995]: every ray, however it was drawn, is weighted by
// the density of the stratified rays over that of all rays. So nothing counts twice, and no light
// is missed where there is no cone.
#include "base/rng.h"
#include "base/sampling.h"
#include "guide/guide.h"

// Standard deviation of a cluster's contribution over all light, below which it gets no rays.
static const float DEVIATION_LEAST = 0.01f;
// Target of that deviation with guided rays, and the deviation of the radiance of a guided ray that
// hits its cluster, over its mean.
static const float DEVIATION_TARGET = 0.01f, DEVIATION_WITHIN = 0.5f;

// Rays of one cone: powers of 2, so that their points form whole nets.
enum { CONE_RAYS_LEAST = 8, CONE_RAYS_MOST = 256 };

// The number of rays to a cluster that contributes a `fraction` of the light.
static int count_rays(const struct guide_cone *cone, float fraction, size_t stratified) {
    if (!(fraction > DEVIATION_LEAST * sqrtf((float)stratified * cone->chance))) return 0;
    const float missed = 1.0f / clampf(cone->filled, 0.01f, 1.0f) - 1.0f;
    const float wanted = sqrf(fraction / DEVIATION_TARGET) * (sqrf(DEVIATION_WITHIN) + missed);
    int rays = CONE_RAYS_LEAST;
    while (rays < CONE_RAYS_MOST && (float)rays < wanted) rays *= 2;
    return rays;
}

static float solid_angle(const struct guide_cone *cone) { return 2.0f * PI_F * cone->versine; }

void guide_rays_allocate(struct guide_rays *rays, float expected, size_t stratified) {
    float all = expected;
    for (int i = 0; i < rays->count; i++) all += rays->cone[i].E;
    int total = 0, kept = 0;
    for (int i = 0; i < rays->count; i++) {
        rays->rays[i] = count_rays(&rays->cone[i], rays->cone[i].E / all, stratified);
        total += rays->rays[i];
    }
    // At most half as many as there are stratified rays.
    int shift = 0;
    while (total >> shift > (int)(stratified / 2)) shift++;
    for (int i = 0; i < rays->count; i++) {
        const int n = rays->rays[i] >> shift;
        if (n == 0) continue;
        rays->cone[kept] = rays->cone[i];
        rays->rays[kept] = n;
        rays->density[kept] = (float)n / solid_angle(&rays->cone[i]);
        kept++;
    }
    rays->count = kept;
}

vec3 guide_cone_sample(const struct guide_cone *cone, vec2 u) {
    const struct frame frame = frame_from_normal(cone->axis);
    return frame_to_world(&frame, sample_uniform_cone(u.x, u.y, cone->versine));
}

// By |w - axis|^2 = 2 (1 - cosine), which is accurate for narrow cones.
bool guide_cone_holds(const struct guide_cone *cone, vec3 w) {
    return v3_dist2(w, cone->axis) <= 2.0f * cone->versine;
}

bool guide_rays_draw(struct guide_rays *rays, struct guide_draw *draw, vec3 *w, float *density) {
    for (; draw->cone < rays->count; draw->cone++, draw->ray = 0) {
        const int c = draw->cone;
        const uint32_t seed = (uint32_t)rng_mix(draw->stream + RNG_GOLDEN * (size_t)c);
        if (draw->ray == 0) rays->first[c] = draw->drawn;
        while (draw->ray < rays->rays[c]) {
            *w = guide_cone_sample(&rays->cone[c], sample_sobol2((uint32_t)draw->ray++, seed));
            if (!(v3_dot(*w, draw->n) > 0.0f)) continue;
            *density = rays->density[c];
            draw->drawn++;
            return true;
        }
    }
    return false;
}

// The cone from which a ray was drawn, even if rounding moved it outside; -1 for a stratified ray.
static int find_own(const struct guide_rays *rays, int drawn) {
    int own = -1;
    while (own + 1 < rays->count && drawn >= rays->first[own + 1]) own++;
    return own;
}

float guide_rays_weight(const struct guide_rays *rays, int drawn, vec3 w, float density) {
    const int own = find_own(rays, drawn);
    float all = density;
    for (int c = 0; c < rays->count; c++)
        if (c == own || guide_cone_holds(&rays->cone[c], w)) all += rays->density[c];
    return density / all;
}
