// SPDX-License-Identifier: Apache-2.0
// Fills the caches over the image's shading points, coarse to fine, in the levels and rounds of
// render_budget.h. The pixels of a level are shuffled, so that a batch is distributed over the
// image. If there are several views, each level goes through all of them.
#include <stdlib.h>

#include "render/render_state.h"

enum { BLOCK_PIXELS = 65536 };  // pixels whose sites are in memory at a time

// What all rounds of filling have in common.
struct record_rounds {
    struct render *r;
    struct render_covering covering;
    struct render_sites sites;
};

static double count_records(const struct render *r) {
    return (double)cache_count_all(r->second_pass.cache);
}

// Fills all levels at `factor` times a; the loops are the range [done, done + span] of the stage.
// If `covering`, the numbers of rays are chosen so that the image is covered in time.
static satin_status cover_levels(struct record_rounds *rounds, struct render_factors factor,
                                 bool covering, double done, double span) {
    struct render *r = rounds->r;
    const float a[CACHE_KINDS] = {r->options.irradiance_a, r->options.radiance_a};
    const uint32_t views = scene_camera_count(&r->scene);
    satin_status status = SATIN_OK;
    int stride = RENDER_COARSEST;
    for (int level = 0;
         level < RENDER_LEVELS && status == SATIN_OK && render_has_stage(r, STAGE_RECORDS);
         level++, stride /= 2) {
        const double start = stats_wall(), before = count_records(r);
        status = fill_limit_rays(r->second_pass.fill,
                                 render_budget_rays(&r->options, &rounds->covering, stride));
        size_t count;
        uint32_t *pixel = render_grid(r, stride, level > 0, &count);
        if (!pixel) status = SATIN_ERROR_MEMORY;
        // Block by block, one view after another.
        const size_t blocks = (count + BLOCK_PIXELS - 1) / BLOCK_PIXELS, all = views * blocks;
        for (size_t i = 0; i < all && status == SATIN_OK; i++) {
            const uint32_t view = (uint32_t)(i / blocks);
            const size_t first = i % blocks * BLOCK_PIXELS, left = count - first;
            const double made = count_records(r);
            const double block = span / RENDER_LEVELS / (double)all;
            render_stage_range(r, done + span * level / RENDER_LEVELS + block * (double)i, block);
            status =
                render_find_sites(r, view, pixel + first, left < BLOCK_PIXELS ? left : BLOCK_PIXELS,
                                  false, &rounds->sites);
            for (enum cache_kind kind = CACHE_IRRADIANCE; kind < CACHE_KINDS && status == SATIN_OK;
                 kind++) {
                const struct fill_sites sites = {
                    .site = rounds->sites.site,
                    .count = rounds->sites.count,
                    .a = a[kind] * factor.of[kind],
                    .factor_max = render_budget_largest_factor(&r->options),
                    .spacing = 1.5f * (float)stride};
                status = fill_records(r->second_pass.fill, kind, &sites);
            }
            if (r->frames.view) r->frames.records[view] += count_records(r) - made;
        }
        free(pixel);
        if (!covering) continue;
        render_budget_level(&r->options, &rounds->covering, stride, count_records(r) - before,
                            render_agreed(r, stats_wall() - start), render_budget_first_round(r));
        if (render_budget_without_records(&r->options, &rounds->covering, stride))
            render_take_course(r, COURSE_WITHOUT_RECORDS);
    }
    return status;
}

// Sets the factors of a at which the image reads the records.
static void read_at(struct render *r, float irradiance, float radiance) {
    r->second_pass.shade.records.a_irradiance = r->options.irradiance_a * irradiance;
    r->second_pass.shade.records.a_radiance = r->options.radiance_a * radiance;
}

// With a time limit: rounds of ever finer records. The image reads them at the finest accuracy of a
// finished round.
static satin_status cover_in_rounds(struct record_rounds *rounds) {
    struct render *r = rounds->r;
    satin_status status = SATIN_OK;
    struct render_factors finished = render_budget_round(&r->options, 0);
    const int count = render_budget_rounds(&r->options);
    render_limit_records(r, NULL);
    read_at(r, finished.of[CACHE_IRRADIANCE], finished.of[CACHE_RADIANCE]);
    double start = stats_wall();
    for (int i = 0; i < count && status == SATIN_OK; i++) {
        const struct render_factors factor = render_budget_round(&r->options, i);
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
            fill_limit_radius(r->second_pass.fill, k, render_budget_least_radius(factor.of[k]));
        status = cover_levels(rounds, factor, i == 0, (double)i / count, 1.0 / count);
        if (!render_has_stage(r, STAGE_RECORDS) || !render_time_remains(r)) break;
        finished = factor;
        stats_set(&r->stats, "records.rounds", i + 1.0);
        if (i > 0) continue;
        struct render_pace pace = {.rays = (double)cache_rays(r->second_pass.cache) /
                                           fmax(render_agreed(r, stats_wall() - start), 1e-9)};
        status = render_image_pilot(r, &pace);
        if (status == SATIN_OK) render_limit_records(r, &pace);
    }
    status = render_limit_end(r, status);
    const float E = finished.of[CACHE_IRRADIANCE], L = finished.of[CACHE_RADIANCE];
    read_at(r, fmaxf(E, fminf(E, 1.0f) * r->options.irradiance_widen),
            fmaxf(L, fminf(L, 1.0f) * r->options.radiance_widen));
    return status;
}

satin_status render_records(struct render *r) {
    struct record_rounds rounds = {.r = r, .covering = {.rays = RENDER_COARSEST}};
    const bool timed = r->options.time > 0.0;
    bool whole;
    render_stage_begin(r, STAGE_RECORDS, 0.0);
    satin_status status = render_cache_load(r, &whole);
    if (status == SATIN_OK && r->motion.at_rest) status = render_keep_records(r);
    if (status == SATIN_OK && !whole && timed) status = cover_in_rounds(&rounds);
    if (status == SATIN_OK && !whole && !timed)
        status = cover_levels(&rounds, (struct render_factors){{1.0f, 1.0f}}, false, 0.0, 1.0);
    if (status == SATIN_OK && !whole && !timed && r->options.adaptive_cache)
        status = render_adaptive_cache(r);
    if (r->motion.at_rest)
        stats_set(&r->stats, "frame.records",
                  count_records(r) - stats_get(&r->stats, "frame.records_kept"));
    if (status == SATIN_OK) r->outcome.saved = render_cache_save(r);
    if (!render_has_stage(r, STAGE_RECORDS)) stats_set(&r->stats, "records.abandoned", 1.0);
    render_sites_free(&rounds.sites);
    fill_statistics(r->second_pass.fill, &r->stats);
    return status;
}
