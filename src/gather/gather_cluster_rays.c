// SPDX-License-Identifier: Apache-2.0
// Rays of a hemisphere to photon clusters (guide_rays.c). They follow the stratified rays.
#include "gather/gather_cluster_rays.h"

#include "gather/gather_layout.h"

// Standard deviation of a beam's light over all light by stratified rays, above which it gets rays
// of its own: that of other light at 400 rays. And the fraction of its cone that is assumed to be
// bright.
static const float BEAM_DEVIATION = 0.05f, BEAM_FILLED = 0.5f;

// The cone that has the beam and is hardly wider, as of a cluster that reflects it; -1: none has.
static int cone_of_beam(const struct guide_rays *rays, const struct photon_beam *beam) {
    for (int c = 0; c < rays->count; c++)
        if (rays->cone[c].versine < 2.0f * beam->versine &&
            guide_cone_holds(&rays->cone[c], beam->axis))
            return c;
    return -1;
}

// Adds the beams of indirect light at the site to the cones.
static void add_beams(const struct gather *g, const struct gather_site *site, float expected,
                      size_t stratified, struct guide_rays *rays) {
    struct photon_beam beam[PHOTON_BEAMS];
    const int found = photon_beams(g->maps, site->p, site->ng, beam);
    for (int i = 0; i < found && rays->count < GUIDE_CONES; i++) {
        const float cosine = v3_dot(beam[i].axis, site->frame.n);
        const float chance = 2.0f * beam[i].versine * cosine, E = beam[i].fraction * expected;
        if (!(sqrf(beam[i].fraction) > sqrf(BEAM_DEVIATION) * (float)stratified * chance)) continue;
        const int c = cone_of_beam(rays, &beam[i]);
        if (c >= 0)
            rays->cone[c].E = fmaxf(rays->cone[c].E, E);
        else
            rays->cone[rays->count++] = (struct guide_cone){.axis = beam[i].axis,
                                                            .versine = beam[i].versine,
                                                            .E = E,
                                                            .chance = chance,
                                                            .filled = BEAM_FILLED};
    }
}

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
    const struct photon_lookups one = {1, &site->p, &site->ng, NULL, &E, &radius, NULL, false};
    photon_irradiance_many(g->maps, g->scene, &one);
    *expected = rgb_luminance(E);
    out->to.count = guide_cones_from(g->clusters, g->scene, &at, out->to.cone, expected);
    add_beams(g, site, *expected, h->stratified, &out->to);
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
