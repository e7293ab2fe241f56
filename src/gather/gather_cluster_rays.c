// SPDX-License-Identifier: Apache-2.0
// Rays of a hemisphere to photon clusters (guide_rays.c). They follow the stratified rays.
#include "gather/gather_cluster_rays.h"

#include "gather/gather_layout.h"

void gather_cluster_rays_add(const struct gather *g, const struct gather_site *site,
                             struct gather_hemisphere *h, struct gather_cluster_rays *out) {
    const struct guide_point at = {site->p, site->frame.n, site->ng};
    *out = (struct gather_cluster_rays){
        .near = {.state = NEAR_SEARCHED,
                 .discs = h->layout->order ? GATHER_NEAR_DISCS_RADIANCE : GATHER_NEAR_DISCS,
                 .p = site->p}};
    if (!g->options->guide_clusters) return;
    out->near.state = NEAR_NOT_SEARCHED;
    if (!g->clusters) return;
    rgb E;
    float *expected = &out->near.expected, radius, density;
    const struct photon_lookups one = {1, &site->p, &site->ng, NULL, &E, &radius, NULL};
    photon_irradiance_many(g->maps, g->scene, &one);
    *expected = rgb_luminance(E);
    out->to.count = guide_cones_from(g->clusters, g->scene, &at, out->to.cone, expected);
    guide_rays_allocate(&out->to, *expected, h->stratified);
    struct guide_draw draw = {.stream = site->stream, .n = site->frame.n};
    vec3 w;
    for (size_t i = h->stratified; guide_rays_draw(&out->to, &draw, &w, &density); i++) {
        const vec3 local = frame_to_local(&site->frame, w);
        h->x[i] = local.x;
        h->y[i] = local.y;
        h->z[i] = local.z;
        const float spread = g->options->texture_filter ? sqrtf(1.0f / density) : 0.0f;
        h->ray[i] = (struct gather_ray){
            .ray = scene_spawn(g->scene, site->p, site->ng, w),
            .item = (uint32_t)i,
            .spread = spread,
            .alpha_least = gather_alpha_least(site, spread),
        };
    }
    h->count = h->stratified + (size_t)draw.drawn;
}

float gather_cluster_rays_weight(const struct gather_cluster_rays *clusters,
                                 const struct gather_hemisphere *h, size_t i) {
    if (clusters->to.count == 0) return 1.0f;
    const float pdf_w = h->layout->order ? 0.5f / PI_F : h->z[i] / PI_F;
    const int drawn = i < h->count ? (int)i - (int)h->stratified : -1;
    return guide_rays_weight(&clusters->to, drawn, h->ray[i].ray.d, (float)h->stratified * pdf_w);
}
