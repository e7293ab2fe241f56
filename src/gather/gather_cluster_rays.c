// SPDX-License-Identifier: Apache-2.0
// Rays of a hemisphere to photon clusters (guide_rays.c). In a scratch they follow those of the
// layout.
#include "gather/gather_cluster_rays.h"

#include "gather/gather_layout.h"

size_t gather_cluster_rays_add(const struct gather *g, const struct gather_layout *layout,
                               const struct gather_site *site, struct gather_scratch *scratch,
                               struct gather_cluster_rays *out) {
    const size_t stratified = gather_layout_rays(layout);
    const struct guide_eye eye = {site->p, site->frame.n, site->ng};
    *out = (struct gather_cluster_rays){.near.p = site->p};
    if (!g->options->guide_clusters) return 0;
    out->near.found = -1;
    if (!g->clusters) return 0;
    float *expected = &out->near.expected, radius, density;
    *expected =
        rgb_luminance(photon_irradiance(g->maps, g->scene, site->p, site->ng, &radius, NULL));
    guide_rays_make(g->clusters, g->scene, &eye, stratified, expected, &out->to);
    struct guide_draw draw = {.stream = site->stream, .n = site->frame.n};
    vec3 w;
    for (size_t i = stratified; guide_rays_draw(&out->to, &draw, &w, &density); i++) {
        const vec3 local = frame_to_local(&site->frame, w);
        scratch->x[i] = local.x;
        scratch->y[i] = local.y;
        scratch->z[i] = local.z;
        const float spread = g->options->texture_filter ? sqrtf(1.0f / density) : 0.0f;
        scratch->rays[i] = (struct gather_ray){
            .ray = scene_spawn(g->scene, site->p, site->ng, w),
            .item = (uint32_t)i,
            .spread = spread,
            .alpha_least = gather_alpha_least(site, spread),
        };
    }
    return (size_t)draw.drawn;
}

void gather_cluster_rays_weigh(const struct gather_cluster_rays *clusters,
                               const struct gather_layout *layout, struct gather_scratch *scratch,
                               size_t count) {
    const size_t stratified = gather_layout_rays(layout);
    if (clusters->to.count == 0) return;
    for (size_t i = 0; i < count; i++) {
        struct gather_ray *ray = &scratch->rays[i];
        const float pdf_w = layout->order ? 0.5f / PI_F : scratch->z[i] / PI_F;
        const float weight = guide_rays_weight(&clusters->to, (int)i - (int)stratified, ray->ray.d,
                                               (float)stratified * pdf_w);
        ray->L = rgb_scale(ray->L, weight);
    }
}
