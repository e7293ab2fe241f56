// SPDX-License-Identifier: Apache-2.0
// Fills the caches over the image's shading points, coarse to fine, in the levels and rounds of
// render_budget.h. The pixels of a level are shuffled, so that a batch is distributed over the
// image. If there are several views, each level goes through all of them.
#include <stdlib.h>

#include "render/render_budget.h"
#include "render/render_state.h"

// What all rounds of filling have in common.
struct record_rounds {
    struct render *r;
    struct render_covering covering;
    struct render_sites sites;
    int number;     // of finished rounds
    bool measured;  // whether the time of the first round follows from its first records
};

// A level of a round.
struct record_level {
    int stride;
    struct render_factors factor;  // factors of a
    uint32_t *pixel;
    size_t count, done;  // pixels of one view; pixels of all views that are done
    double begin, span;  // its loops are the range [begin, begin + span] of the stage
    bool covering;       // the numbers of rays are chosen so that the image is covered in time
    float rays_least;    // see fill_sites
};

static double count_records(const struct render *r) {
    return (double)cache_count_all(r->second_pass.cache);
}

// The pixels of a level in all views.
static double all_pixels(const struct record_rounds *rounds, const struct record_level *level) {
    return (double)level->count * (double)scene_camera_count(&rounds->r->scene);
}

static struct fill_sites sites_to_cover(const struct record_rounds *rounds,
                                        const struct record_level *level, enum cache_kind kind) {
    const satin_options *o = &rounds->r->options;
    return (struct fill_sites){
        .site = rounds->sites.site,
        .count = rounds->sites.count,
        .a = rounds->r->second_pass.cache->store[kind].options.a * level->factor.of[kind],
        .factor_max = render_budget_search(o, rounds->number).of[kind],
        .spacing = 1.5f * (float)level->stride,
        .rays_least = level->rays_least};
}

// Chooses the rays of the records of this level, of whose pixels `count` have the current sites.
static satin_status plan_rays(struct record_rounds *rounds, const struct record_level *level,
                              size_t count) {
    struct render *r = rounds->r;
    const double pixels = all_pixels(rounds, level);
    double needed = 0.0;
    for (enum cache_kind kind = CACHE_IRRADIANCE; kind < CACHE_KINDS; kind++) {
        const struct fill_sites sites = sites_to_cover(rounds, level, kind);
        needed += fill_uncovered(r->second_pass.fill, kind, &sites);
    }
    needed *= (pixels - (double)level->done) / (double)count;
    render_covering_plan(&r->options, &rounds->covering, level->stride, pixels, needed,
                         render_budget_first_round(r));
    return fill_limit_rays(r->second_pass.fill,
                           render_covering_rays(&r->options, &rounds->covering, level->stride));
}

// Pixels of a level that one view sees, whose sites are in memory.
struct record_block {
    uint32_t view;
    size_t first, count;  // pixels
    double found;         // wall clock when its sites were found
    double records;       // number of records before
};

// Takes the next block, one view after another: finds its sites, and the rays of their records.
static satin_status begin_block(struct record_rounds *rounds, const struct record_level *level,
                                struct record_block *block) {
    struct render *r = rounds->r;
    const bool first = level->covering && level->stride == RENDER_COARSEST && level->done == 0;
    block->view = (uint32_t)(level->done / level->count);
    block->first = level->done % level->count;
    block->count = first ? RENDER_FIRST_PIXELS : RENDER_BLOCK_PIXELS;
    if (block->view > 0 && block->first == 0) block->count = RENDER_VIEW_PIXELS;
    if (block->count > level->count - block->first) block->count = level->count - block->first;
    block->records = count_records(r);
    const double step = level->span / all_pixels(rounds, level), start = stats_wall();
    render_stage_range(r, level->begin + step * (double)level->done, step * (double)block->count);
    satin_status status =
        render_find_sites(r, block->view, level->pixel + block->first, &block->count,
                          RENDER_BLOCK_SITES, false, &rounds->sites);
    rounds->covering.search += render_agreed(r, stats_wall() - start);
    rounds->covering.pixels += (double)block->count;
    if (status == SATIN_OK && level->covering) status = plan_rays(rounds, level, block->count);
    block->found = stats_wall();
    return status;
}

static void end_block(struct record_rounds *rounds, struct record_level *level,
                      const struct record_block *block) {
    struct render *r = rounds->r;
    const double made = count_records(r) - block->records;
    const double seconds = render_agreed(r, stats_wall() - block->found);
    level->done += block->count;
    if (block->view > 0 && !render_budget_view_pays(made, (double)block->count))
        level->done = (block->view + 1) * level->count;
    if (level->covering)
        render_covering_filled(&r->options, &rounds->covering, level->stride, made, seconds);
    if (r->frames.view) r->frames.records[block->view] += made;
}

// Whether paths would find the light: caustics are noise for them, which a denoiser removes.
static bool paths_find_light(const struct render *r) {
    return render_budget_caustics(photon_caustic_fraction(r->first_pass.maps)) < 1.0;
}

// Divides the time between records and image by the first block with records, found at `found`. A
// denoised image that would have too few samples is one of paths.
static satin_status measure_first(struct record_rounds *rounds, double found) {
    struct render *r = rounds->r;
    const double rays = (double)cache_rays(r->second_pass.cache);
    if (rounds->measured || !(rays > 0.0)) return SATIN_OK;
    const double seconds = render_agreed(r, stats_wall() - found);
    struct render_pace pace = {.rays = rays / fmax(seconds, 1e-9)};
    rounds->measured = true;
    const satin_status status = render_first_pilot(r, &pace);
    if (status != SATIN_OK) return status;
    if (r->options.denoise && render_budget_traces_paths(r, pace.samples) && paths_find_light(r))
        return render_trace_paths(r);
    render_limit_first_records(r, &pace);
    return SATIN_OK;
}

// Whether the level is filled although its sites have to be searched.
static bool level_pays(const struct record_rounds *rounds, const struct record_level *level) {
    return !level->covering || render_covering_pays(&rounds->covering, all_pixels(rounds, level),
                                                    render_budget_first_round(rounds->r));
}

// Fills all levels at `factor` times a; the loops are the range [done, done + span] of the stage.
// If `covering`, the numbers of rays are chosen so that the image is covered in time.
static satin_status cover_levels(struct record_rounds *rounds, struct render_factors factor,
                                 bool covering, double done, double span) {
    struct render *r = rounds->r;
    satin_status status = covering ? SATIN_OK : fill_limit_rays(r->second_pass.fill, 1.0f);
    bool pays = true;
    for (int i = 0; i < RENDER_LEVELS && status == SATIN_OK && pays; i++) {
        struct record_level level = {.stride = RENDER_COARSEST >> i,
                                     .factor = factor,
                                     .begin = done + span * i / RENDER_LEVELS,
                                     .span = span / RENDER_LEVELS,
                                     .covering = covering,
                                     .rays_least = render_budget_rays_least(covering)};
        level.pixel = render_grid(r, level.stride, i > 0, &level.count);
        if (!level.pixel) return SATIN_ERROR_MEMORY;
        pays = level_pays(rounds, &level);
        while (pays && status == SATIN_OK && (double)level.done < all_pixels(rounds, &level)) {
            struct record_block block;
            status = begin_block(rounds, &level, &block);
            for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++) {
                const struct fill_sites sites = sites_to_cover(rounds, &level, k);
                status = fill_records(r->second_pass.fill, k, &sites);
            }
            end_block(rounds, &level, &block);
            if (status == SATIN_OK && covering) status = measure_first(rounds, block.found);
            pays = render_has_stage(r, STAGE_RECORDS);
        }
        free(level.pixel);
        render_covering_next(&rounds->covering);
    }
    return status;
}

// Sets the factors of a at which the image reads the records.
static void read_at(struct render *r, struct render_factors factor) {
    struct cache_reader *reader = &r->second_pass.shade.records;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        reader->a[k] = reader->options[k].a * factor.of[k];
}

// Finds records within no more than these factors of a from now on. A later round reads all records
// more closely: after the fifth, a sample of indirect-room takes .65 of the time.
static satin_status search_within(struct render *r, struct render_factors most) {
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        struct cache_store *store = &r->second_pass.cache->store[k];
        if (!cache_tree_limit(&store->tree, store->options.a * most.of[k]))
            return SATIN_ERROR_MEMORY;
    }
    return SATIN_OK;
}

// The factors for the image after the last round: widened, but not beyond those of the first one.
// With 2 as the largest, as records of the second round then were, cornell-metal had 1.14 times the
// error at 10 CPU seconds.
static struct render_factors widen(const struct render *r, struct render_factors finished) {
    const struct cache_options *options = r->second_pass.shade.records.options;
    const float largest = render_budget_largest_factor(&r->options);
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        finished.of[k] = fminf(finished.of[k] * options[k].widen, largest);
    return finished;
}

// With a time limit: rounds of ever finer records. The image reads them at the finest accuracy of a
// finished round.
static satin_status cover_in_rounds(struct record_rounds *rounds) {
    struct render *r = rounds->r;
    satin_status status = SATIN_OK;
    struct render_factors finished = render_budget_round(&r->options, 0);
    const int count = render_budget_rounds(&r->options);
    render_limit_records(r, NULL);
    read_at(r, finished);
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        r->second_pass.cache->store[k].widens = true;
    const double start = stats_wall();
    for (int i = 0; i < count && status == SATIN_OK; i++) {
        const struct render_factors factor = render_budget_round(&r->options, i);
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
            fill_limit_radius(r->second_pass.fill, k, render_budget_least_radius(factor.of[k]));
        status = search_within(r, render_budget_search(&r->options, i));
        if (status == SATIN_OK)
            status = cover_levels(rounds, factor, i == 0, (double)i / count, 1.0 / count);
        if (status != SATIN_OK || !render_has_stage(r, STAGE_RECORDS) || !render_time_remains(r))
            break;
        finished = factor;
        rounds->number = i + 1;
        stats_set(&r->stats, "records.rounds", rounds->number);
        if (i > 0) continue;
        const double seconds = render_agreed(r, stats_wall() - start);
        if (!render_budget_next_round(r, render_covering_by_all_rays(&rounds->covering, seconds))) {
            render_limit_coarse_records(r);
            continue;
        }
        struct render_pace pace = {.rays = (double)cache_rays(r->second_pass.cache) /
                                           fmax(seconds, 1e-9)};
        status = render_image_pilot(r, &pace);
        if (status == SATIN_OK) render_limit_records(r, &pace);
    }
    status = render_limit_end(r, status);
    read_at(r, widen(r, finished));
    if (status == SATIN_OK)
        status = search_within(r, render_budget_search(&r->options, rounds->number));
    return status;
}

// Few records are smoothed. Later rounds have so many that it costs more detail than noise.
static satin_status remove_noise(struct render *r, bool few) {
    const float a = r->second_pass.shade.records.a[CACHE_IRRADIANCE];
    return few ? fill_smooth(r->second_pass.fill, a) : fill_spread_outliers(r->second_pass.fill, a);
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
    render_sites_free(&rounds.sites);
    if (status == SATIN_OK && !whole && !timed && r->options.adaptive_cache)
        status = render_adaptive_cache(r);
    if (r->motion.at_rest)
        stats_set(&r->stats, "frame.records",
                  count_records(r) - stats_get(&r->stats, "frame.records_kept"));
    if (status == SATIN_OK) r->outcome.saved = render_cache_save(r);
    if (status == SATIN_OK && render_has_stage(r, STAGE_RECORDS))
        status = remove_noise(r, timed && rounds.number < 2);
    if (!render_has_stage(r, STAGE_RECORDS)) stats_set(&r->stats, "records.abandoned", 1.0);
    fill_statistics(r->second_pass.fill, &r->stats);
    return status;
}
