// SPDX-License-Identifier: Apache-2.0
// Guided rays: beside the stratified rays of a hemisphere some more go to the photon clusters that
// the site sees, as guide_rays.c allocates them. Together they are one estimate by the balance
// heuristic [Veach and Guibas 1995]: every ray, however it was drawn, counts by the density of the
// stratified rays over that of all, so nothing is counted twice and no light is left out where a
// cluster was not guessed.
#include "gather/gather_guide.h"

#include "base/rng.h"
#include "gather/gather_layout.h"

size_t gather_guide_rays(const struct gather *g, const struct gather_layout *layout,
                         const struct gather_site *site, struct gather_scratch *scratch,
                         struct gather_guide *out) {
    const size_t stratified = gather_layout_rays(layout);
    const struct guide_eye eye = {site->p, site->frame.n, site->ng};
    struct guide_rays *to = &out->to;
    *out = (struct gather_guide){.near.p = site->p};
    if (!g->options->gather_guide) return 0;
    out->near.found = -1;
    if (!g->clusters) return 0;
    float radius;
    out->near.expected =
        rgb_luminance(photon_irradiance(g->maps, g->scene, site->p, site->ng, &radius, NULL));
    to->count = guide_cones_from(g->clusters, g->scene, &eye, to->cone, &out->near.expected);
    if (to->count == 0) return 0;
    guide_rays_allocate(to, out->near.expected, stratified);
    size_t i = stratified;
    for (int c = 0; c < to->count; c++) {
        out->first[c] = i;
        const uint32_t seed = (uint32_t)rng_mix(site->stream + 0x9e3779b97f4a7c15ull * (size_t)c);
        for (int k = 0; k < to->rays[c]; k++) {
            const vec3 w = guide_cone_sample(&to->cone[c], sample_sobol2((uint32_t)k, seed));
            const vec3 local = frame_to_local(&site->frame, w);
            if (!(local.z > 0.0f)) continue;
            scratch->x[i] = local.x;
            scratch->y[i] = local.y;
            scratch->z[i] = local.z;
            scratch->rays[i] = (struct gather_ray){
                .ray = scene_spawn(g->scene, site->p, site->ng, w),
                .item = (uint32_t)i,
                .spread = g->options->texture_filter ? sqrtf(1.0f / to->density[c]) : 0.0f,
            };
            i++;
        }
    }
    return i - stratified;
}

void gather_guide_weigh(const struct gather_guide *guide, const struct gather_layout *layout,
                        struct gather_scratch *scratch, size_t count) {
    const size_t stratified = gather_layout_rays(layout);
    if (guide->to.count == 0) return;
    int own = -1;  // the cone that a guided ray was drawn from, whatever the last digit says
    for (size_t i = 0; i < count; i++) {
        while (own + 1 < guide->to.count && i >= guide->first[own + 1]) own++;
        struct gather_ray *ray = &scratch->rays[i];
        float density = (float)stratified * (layout->order ? 0.5f / PI_F : scratch->z[i] / PI_F);
        const float all = guide_rays_density(&guide->to, own, ray->ray.d, density);
        ray->L = rgb_scale(ray->L, density / all);
    }
}
