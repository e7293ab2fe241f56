// SPDX-License-Identifier: Apache-2.0
// Path tracing with MIS of light and BRDF sampling: the reference, and the first pass `path`.
// Depths count edges as Mitsuba 3 does: a path of max_depth edges is the longest that is kept.
#include "gather/gather.h"

// Survival is never certain, so that no path is endless between perfect mirrors.
static const float ROULETTE_MAX = 0.95f;

// Emitted light that the ray meets: at the surface it hit, or from the environment.
static rgb emitted(const struct gather *g, const struct ray *ray, const struct surfel *hit) {
    return hit ? light_emitted(g->scene, hit, v3_neg(ray->d)) : light_environment(g->scene, ray->d);
}

rgb gather_path(const struct gather *g, struct ray ray, int depth, bool emission,
                struct sampler *sampler, struct gather_first *first) {
    const struct satin_scene *scene = g->scene;
    const int max_depth = g->options->max_depth;
    const struct gather_mis both = {{{BRDF_ALL, 1.0f}}};
    rgb L = rgb_grey(0.0f), T = rgb_grey(1.0f);
    const bool from_eye = depth == 0;
    float eta = 1.0f,
          pdf_w = 0.0f;  // density of the BRDF sample that made the ray; 0: delta or eye
    struct gather_point from = {0};
    for (;;) {
        struct surfel s;
        bool hit = scene_intersect(scene, &ray, &s);
        if (first) *first = hit ? (struct gather_first){s.t, s.ng} : GATHER_NOTHING;
        if (emission && (hit ? s.light >= 0 : scene->environment >= 0)) {
            rgb Le = emitted(g, &ray, hit ? &s : NULL);
            float weight = 1.0f;
            if (pdf_w > 0.0f && !rgb_black(Le))
                weight =
                    mis_power(pdf_w, gather_light_pdf(g, from.surfel.p, ray.d, hit ? &s : NULL));
            L = rgb_fma(L, T, rgb_scale(Le, weight));
        }
        if (!hit || (max_depth >= 0 && depth + 1 >= max_depth)) break;

        gather_point_make(scene, &s, ray.d, &from);
        if (first && !(from.lobes & BRDF_SMOOTH)) first->ng = GATHER_NOTHING.ng;
        first = NULL;
        if (!from.lobes) break;
        L = rgb_fma(L, T, gather_direct(g, &from, both, 1, *sampler));
        sampler->dimension += 2;

        struct brdf_sample next;
        float u_lobe = sampler_1d(sampler);
        vec2 u = sampler_2d(sampler);
        if (!brdf_sample(&from.brdf, from.wo_l, u_lobe, u.x, u.y, BRDF_ALL, BRDF_RADIANCE, &next))
            break;
        T = rgb_mul(T, next.weight);
        eta *= next.eta;
        pdf_w = next.pdf_w;
        emission = emission || pdf_w > 0.0f || from_eye;
        depth++;
        ray = scene_spawn(scene, s.p, s.ng, frame_to_world(&from.frame, next.wi));
        if (depth >= g->options->rr_depth) {
            float survive = fminf(rgb_max(T) * eta * eta, ROULETTE_MAX);
            if (!(sampler_1d(sampler) < survive)) break;
            T = rgb_scale(T, 1.0f / survive);
        }
        if (rgb_black(T)) break;
    }
    return L;
}
