// SPDX-License-Identifier: Apache-2.0
// Points at which records of the indirect bounces will be read: random walks from the eye, whose
// bounces are drawn from the smooth lobes, as those of gather rays are weighted.
#include "shade/shade_eye.h"

// One gather ray among hundreds reads the light at a hit, so records need not be denser than this
// fraction of the path's length from the eye.
static const float FOOTPRINT = 0.05f;

// Draws a segment of a walk that leaves p.
static bool draw_segment(const struct gather *g, const struct shading_point *p,
                         struct sampler *sampler, struct ray *out) {
    struct brdf_sample next;
    float u_lobe = sampler_1d(sampler);
    vec2 u = sampler_2d(sampler);
    if (!brdf_sample_wi(&p->brdf, p->wo_l, u_lobe, u, BRDF_SMOOTH, BRDF_RADIANCE, &next))
        return false;
    *out = scene_spawn(g->scene, p->interaction.p, p->interaction.ng,
                       frame_to_world(&p->frame, next.wi));
    return true;
}

bool shade_walk_ray(const struct shade *shade, int x, int y, struct ray *out) {
    struct shade_eye eye;
    struct sampler sampler = shade_eye_sampler(shade->g, x, y, 0, RNG_SITE);
    shade_eye_trace(shade, x, y, &sampler, &eye);
    const struct shade_vertex *start = shade_eye_choose(&eye, sampler_1d(&sampler), NULL);
    return start && draw_segment(shade->g, &start->point, &sampler, out);
}

bool shade_walk(const struct shade *shade, int x, int y, int bounce, struct fill_site *out) {
    const struct gather *g = shade->g;
    struct shade_eye eye;
    struct sampler sampler = shade_eye_sampler(g, x, y, (uint32_t)bounce, RNG_SITE);
    shade_eye_trace(shade, x, y, &sampler, &eye);
    const struct shade_vertex *start = shade_eye_choose(&eye, sampler_1d(&sampler), NULL);
    if (!start) return false;
    struct shading_point p = start->point;
    float length = 0.0f;
    for (int i = 0; i < bounce; i++) {
        struct ray ray;
        struct gather_first first;
        if (!draw_segment(g, &p, &sampler, &ray)) return false;
        if (!gather_follow(g, ray, &sampler, &first, &p)) return false;
        length += first.r;
    }
    unsigned kinds = cache_plan_kinds(&shade->records, &p);
    *out = shade_site(&p, FOOTPRINT * length, ((uint64_t)sampler.seed << 20) + (uint64_t)bounce,
                      kinds);
    return kinds != 0;
}
