// SPDX-License-Identifier: Apache-2.0
// Lookups whose noise a glossy lobe shows, and entries that are gathered anew without it.
#include <stdlib.h>

#include "gather/gather_near.h"
#include "gather/gather_segment.h"

bool gather_look_up(const struct gather *g, struct ray ray, float pdf_w, struct sampler *sampler,
                    struct gather_lookup *out) {
    const struct gather_segment_start start = {.ray = ray, .depth = gather_hit_depth(g) - 1};
    struct gather_segment segment;
    struct shading_point y;
    if (!gather_looks_up(g) || !gather_segment_trace(g, &start, sampler, &segment, &y))
        return false;
    if (!(y.lobes & BRDF_DIFFUSE) ||
        !gather_reads_photons(g, gather_hit_depth(g) + segment.specular))
        return false;
    float radius;
    rgb E;
    const float t = y.interaction.t;
    const int more = segment.specular + g->deeper;
    const struct photon_lookups one = {1,  &y.interaction.p, &y.ng,       &more,
                                       &E, &radius,          &out->entry, false};
    photon_irradiance_many(g->maps, g->scene, &one);
    const bool near = gather_is_near(g, t, radius, GATHER_NEAR_DISCS);
    if (!gather_is_reliable(g, &y, radius, near)) return false;
    const rgb albedo = rgb_mul(segment.T, brdf_albedo(&y.brdf, y.wo_l, BRDF_DIFFUSE));
    out->L = rgb_scale(rgb_mul(albedo, E), 1.0f / PI_F);
    out->common = 0.0f;
    if (out->entry < 0) return true;
    const float disc =
        PI_F * sqrf(photon_irradiance_radius(g->maps, (size_t)out->entry)) * fabsf(y.wo_l.z);
    out->common = fminf(pdf_w * disc / sqrf(t), 1.0f);
    return true;
}

// The stream of an entry's random numbers, which no site of a record has.
static const uint64_t ENTRY_STREAM = 0x7ef1ull << 40;

struct entries_loop {
    struct gather g;
    const int *entry;
    rgb *E;
    const struct gather_layout *layout;
    struct gather_worker *worker;
};

static void gather_entries_chunk(void *ctx, size_t begin, size_t end, int worker) {
    const struct entries_loop *loop = ctx;
    const struct gather_worker *w = &loop->worker[worker];
    for (size_t i = begin; i < end; i++) {
        const size_t entry = (size_t)loop->entry[i];
        struct gather_site site = {.stream = ENTRY_STREAM | entry, .record = true};
        photon_irradiance_position(loop->g.maps, entry, &site.p, &site.ng);
        site.frame = frame_from_normal(site.ng);
        struct cache_irradiance_value value;
        gather_hemisphere_trace(&loop->g, loop->layout, &site, w->scratch, w->hemisphere);
        gather_hemisphere_irradiance(w->hemisphere, SATIN_GRADIENTS_NONE, &value);
        loop->E[i] = value.E;
    }
}

satin_status gather_entries(const struct gather *g, const int *entry, size_t count, int rays,
                            struct parallel *pool, rgb *E) {
    struct gather_layout *layout = gather_layout_new(rays, SATIN_HSH, 0);
    struct entries_loop loop = {*g, entry, E, layout, NULL};
    loop.g.deeper = 1;
    if (layout) loop.worker = gather_workers_new(pool, gather_layout_rays(layout));
    const struct parallel_results gathered = {.slot = {{E, sizeof *E}}, .journaled = true};
    satin_status status = SATIN_OK;
    if (!loop.worker)
        status = SATIN_ERROR_MEMORY;
    else if (!parallel_for_results(pool, count, 1, gather_entries_chunk, &loop, &gathered))
        status = SATIN_CANCELLED;
    gather_workers_free(loop.worker, parallel_threads(pool));
    gather_layout_free(layout);
    return status;
}
