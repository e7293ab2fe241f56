// SPDX-License-Identifier: Apache-2.0
// Rays of a radiance record that are drawn by the glossy lobes of its site. The lobe that the image
// sees fills a small part of the hemisphere: of the stratified rays of a record, .05 are in that of
// a rough metal of alpha .15. So as many rays are drawn by the lobe as there are stratified ones.
// All rays are one estimate of the incident radiance by the balance heuristic [Veach and Guibas
// 1995]: each is weighted by the density of the stratified rays over that of all rays. Lobes in
// other directions, as of points around the record, are sampled by the stratified rays too. Of
// gradients the lobe's rays show nothing, since they have no strata; they are of the other rays
// alone.
#include "gather/gather_lobe_rays.h"

#include "gather/gather_layout.h"

enum { LOBE_DIMENSION = 0 };  // of the sampler

// Draws the rays, and returns the number of those that did not fail.
static size_t draw_lobe_rays(const struct gather *g, const struct gather_site *site, size_t wanted,
                             struct gather_hemisphere *h) {
    const uint32_t seed = (uint32_t)rng_mix(site->stream + RNG_GOLDEN);
    size_t drawn = 0;
    for (size_t i = 0; i < wanted; i++) {
        struct sampler u = {(uint32_t)i, seed, LOBE_DIMENSION};
        struct brdf_sample b;
        const vec2 uv = sampler_2d(&u);
        const float u_lobe = sampler_1d(&u);
        if (!brdf_sample_wi(site->glossy, site->wo, u_lobe, uv, BRDF_GLOSSY, BRDF_RADIANCE, &b) ||
            !(b.wi.z > 0.0f))
            continue;
        const size_t at = h->count + drawn++;
        h->x[at] = b.wi.x;
        h->y[at] = b.wi.y;
        h->z[at] = b.wi.z;
        h->ray[at] = (struct gather_ray){
            .ray = scene_spawn(g->scene, site->p, site->ng, frame_to_world(&site->frame, b.wi)),
            .item = (uint32_t)at};
    }
    return drawn;
}

void gather_lobe_rays_add(const struct gather *g, const struct gather_site *site,
                          const struct gather_cluster_rays *clusters, struct gather_hemisphere *h) {
    h->all = h->count;
    if (!site->glossy || !h->layout->order) return;
    const size_t wanted = h->stratified;
    h->all += draw_lobe_rays(g, site, wanted, h);
    const float stratified = (float)h->stratified * 0.5f / PI_F;
    for (size_t i = 0; i < h->all; i++) {
        const vec3 wi = v3(h->x[i], h->y[i], h->z[i]);
        const float others = stratified / gather_cluster_rays_weight(clusters, h, i);
        const float all =
            others + (float)wanted * brdf_pdf(site->glossy, site->wo, wi, BRDF_GLOSSY);
        // L of the other rays is weighted as if those of the lobes did not exist.
        h->weight[i] = (i < h->count ? others : stratified) / all;
        if (i < h->count) continue;
        h->ray[i].spread = g->options->texture_filter ? 1.0f / sqrtf(all) : 0.0f;
        h->ray[i].alpha_least = gather_alpha_least(site, h->ray[i].spread);
    }
}
