// SPDX-License-Identifier: Apache-2.0
// A segment of a light path: from one surface with a smooth lobe to the next, through any number of
// ideal specular surfaces (S* in the path table). A gather ray is the segment from x to y; every
// further bounce is another one.
#include "gather/gather_segment.h"

enum { DELTA_SURE = 32 };  // ideal specular surfaces in a row before Russian roulette starts

// The probability of continuing at each further one: light that is trapped in a sheet of glass is
// reflected some hundred times.
static const float DELTA_SURVIVE = 0.98f;

// Adds the emitted light at `hit`, or that of the environment if `hit` is NULL.
static void add_met_light(const struct gather *g, const struct gather_segment_start *start,
                          const struct light_chain *chain, vec3 d, const struct interaction *hit,
                          struct gather_segment *out) {
    const struct gather_met_light met = gather_meet_light(g, chain, d, start->lit, hit);
    if (!met.direct) {
        if (!gather_within_depth(g, start->depth + out->specular, 1)) return;
        out->Le_specular = rgb_fma(out->Le_specular, out->T, met.Le);
    } else if (chain->crossed <= gather_panes(g, start->depth)) {
        out->Le = rgb_mul(out->T, met.Le);
        out->light_pdf = met.light_pdf;
    }
}

// The probability that a segment ends at a surface with both smooth and ideal specular lobes, in
// proportion to what they reflect.
static float end_probability(const struct shading_point *p) {
    if (!(p->lobes & BRDF_DELTA)) return p->lobes & BRDF_SMOOTH ? 1.0f : 0.0f;
    if (!(p->lobes & BRDF_SMOOTH)) return 0.0f;
    const float smooth = rgb_max(brdf_albedo(&p->brdf, p->wo_l, BRDF_SMOOTH));
    const float delta = rgb_max(brdf_albedo(&p->brdf, p->wo_l, BRDF_DELTA));
    return smooth + delta > 0.0f ? smooth / (smooth + delta) : 1.0f;
}

bool gather_segment_trace(const struct gather *g, const struct gather_segment_start *start,
                          struct sampler *sampler, struct gather_segment *out,
                          struct shading_point *end) {
    struct ray ray = start->ray;
    struct light_chain chain = light_chain_begin(&ray);
    float distance = 0.0f;
    *out = (struct gather_segment){.T = rgb_grey(1.0f), .first = GATHER_NOTHING};
    for (int i = 0;; i++) {
        if (i >= DELTA_SURE) {
            if (!(sampler_1d(sampler) < DELTA_SURVIVE)) return false;
            out->T = rgb_scale(out->T, 1.0f / DELTA_SURVIVE);
        }
        struct interaction s;
        const bool hit = scene_intersect(g->scene, &ray, &s);
        if (start->lit) add_met_light(g, start, &chain, ray.d, hit ? &s : NULL, out);
        if (!hit) return false;
        if (i == 0) out->first = (struct gather_first){s.t, s.ng};
        distance += s.t;
        s.footprint = start->spread * distance;
        scene_shading_point_make(g->scene, &s, ray.d, end);
        const float stop = end_probability(end), u = stop < 1.0f ? sampler_1d(sampler) : 0.0f;
        if (u < stop) {
            out->T = rgb_scale(out->T, 1.0f / stop);
            end->brdf.alpha_least = start->alpha_least;
            return true;
        }
        out->first.ng = GATHER_NOTHING.ng;
        struct brdf_sample next;
        if (!end->lobes) return false;
        const vec2 facet = brdf_is_polished(&end->brdf) ? sampler_2d(sampler) : (vec2){0.5f, 0.5f};
        if (!brdf_sample_wi(&end->brdf, end->wo_l, sample_rest(u, stop), facet, BRDF_DELTA,
                            BRDF_RADIANCE, &next))
            return false;
        out->T = rgb_mul(out->T, rgb_scale(next.weight, 1.0f / (1.0f - stop)));
        out->specular++;
        light_chain_pass(&chain, g->scene, &s, v3_neg(ray.d), end->wo_l, &next);
        ray = scene_spawn(g->scene, s.p, s.ng, frame_to_world(&end->frame, next.wi));
    }
}

bool gather_follow(const struct gather *g, struct ray ray, struct sampler *sampler,
                   struct gather_first *first, struct shading_point *out) {
    struct gather_segment segment;
    const bool found =
        gather_segment_trace(g, &(struct gather_segment_start){.ray = ray}, sampler, &segment, out);
    *first = segment.first;
    return found;
}
