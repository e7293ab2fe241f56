// SPDX-License-Identifier: Apache-2.0
// Which rays of a hemisphere go to photon clusters: its stratified rays meet a small bright cluster
// by luck; some more rays go to each one that the point sees. Together they are one estimate by the
// balance heuristic [Veach and Guibas 1995]: every ray, however it was drawn, counts by the density
// of the stratified rays over that of all, so nothing is counted twice and no light is left out
// where a cluster was not guessed.
#include "base/rng.h"
#include "base/sampling.h"
#include "guide/guide.h"

// The deviation of what comes from one cluster over all light, below which luck is good enough.
static const float LUCK = 0.01f;
// The deviation, over all light, that guided rays aim at; and that of one of them that meets its
// cluster, over its own mean.
static const float AIM = 0.01f, SPREAD = 0.5f;

enum { CONE_RAYS_LEAST = 8, CONE_RAYS_MOST = 256 };  // rays of one cone, powers of 2: whole nets

// Number of rays to a cluster that sends a `fraction` of the light.
static int count_rays(const struct guide_cone *cone, float fraction, size_t stratified) {
    if (!(fraction > LUCK * sqrtf((float)stratified * cone->chance))) return 0;
    const float missed = 1.0f / clampf(cone->filled, 0.01f, 1.0f) - 1.0f;
    const float wanted = sqrf(fraction / AIM) * (sqrf(SPREAD) + missed);
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
    // No more than half as many as there are without.
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

void guide_rays_make(const struct guide_clusters *clusters, const struct satin_scene *scene,
                     const struct guide_eye *eye, size_t stratified, float *expected,
                     struct guide_rays *out) {
    out->count = clusters ? guide_cones_from(clusters, scene, eye, out->cone, expected) : 0;
    if (out->count > 0) guide_rays_allocate(out, *expected, stratified);
}

vec3 guide_cone_sample(const struct guide_cone *cone, vec2 u) {
    // As sample_uniform_cone, which has no digits left for the narrowest.
    const struct frame frame = frame_from_normal(cone->axis);
    const float away = u.x * cone->versine, sine = safe_sqrtf(away * (2.0f - away));
    const float phi = 2.0f * PI_F * u.y;
    return frame_to_world(&frame, v3(sine * cosf(phi), sine * sinf(phi), 1.0f - away));
}

// Whether a direction is in the cone: |w - axis|^2 = 2 (1 - cosine) keeps the digits.
bool guide_cone_holds(const struct guide_cone *cone, vec3 w) {
    return v3_dist2(w, cone->axis) <= 2.0f * cone->versine;
}

bool guide_rays_draw(struct guide_rays *rays, struct guide_draw *draw, vec3 *w, float *density) {
    for (; draw->cone < rays->count; draw->cone++, draw->ray = 0) {
        const int c = draw->cone;
        const uint32_t seed = (uint32_t)rng_mix(draw->stream + 0x9e3779b97f4a7c15ull * (size_t)c);
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

// The cone that a ray was drawn from, whatever the last digit says; -1 for a stratified ray.
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
